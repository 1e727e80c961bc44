// From the blended channels to the picture: core/model/README.md 1, 2, 4 and 6 as photographed, core/relight/README.md 1 under
// another light. One pass over the screen.
precision highp sampler2DArray;

uniform sampler2D reflected;                                 // mirror_rays.glsl
uniform bool traced;                                         // it is there
uniform sampler2DArray pictures;                             // what flat panes and mirrors show, turned left to right
uniform sampler2D probe0, probe1, probe2, probe3;            // radiance, distance
uniform vec3 probe_places[4];
uniform int probe_count;
uniform float probe_side;
uniform bool background;
uniform int show;           // 0 picture, 1 albedo, 2 normals, 3 roughness, 4 depth, 5 what the glass adds, 6 confidence
uniform vec3 gain;
uniform vec2 depth_range;
uniform vec3 scale[5];      // colours of confidences from 0 to 1, as the screen has them
uniform float unseen;       // grey of what no photo saw

out vec4 shown;

const float kLobe = 4.0 / 3.14159;  // width of a lobe in GGX alphas, over the angle of half a circle
const float kFirstStep = 0.1, kGrowth = 1.2;  // of the way along a reflected ray
const int kSteps = 28, kHalvings = 5;
const float kSheetSpecular = 0.002;
const vec4 kNothing = vec4(0.0, 0.0, 0.0, 1.0);  // met by a ray

// Along the ray until it is as far from the middle of the probe as what is seen in that direction; to the sky, if it never is.
vec3 met(sampler2D probe, vec3 centre, vec3 origin, vec3 d, float level) {
  vec3 q = origin - centre;
  float before = 0.0, t = kFirstStep * length(q) + 1e-4;
  bool found = false, before_it = false;  // a ray that begins behind what the probe sees must come out first
  for (int i = 0; i < kSteps && !found; ++i) {
    vec3 p = q + t * d;
    bool behind = length(p) >= textureLod(probe, octahedral_place(p), 0.0).a;
    found = behind && before_it;
    before_it = before_it || !behind;
    if (!found) before = t, t *= kGrowth;
  }
  if (!found) return textureLod(probe, octahedral_place(d), level).rgb;
  for (int i = 0; i < kHalvings; ++i) {
    float middle = 0.5 * (before + t);
    vec3 p = q + middle * d;
    if (length(p) >= textureLod(probe, octahedral_place(p), 0.0).a) t = middle;
    else before = middle;
  }
  return textureLod(probe, octahedral_place(q + t * d), level).rgb;
}
vec3 mirrored(vec3 origin, vec3 d, float roughness) {
  int nearest = 0;
  for (int i = 1; i < probe_count; ++i)
    if (distance(origin, probe_places[i]) < distance(origin, probe_places[nearest])) nearest = i;
  float level = log2(1.0 + kLobe * roughness * roughness * probe_side);  // texels of the probe in the lobe
  if (nearest == 0) return met(probe0, probe_places[0], origin, d, level);
  if (nearest == 1) return met(probe1, probe_places[1], origin, d, level);
  if (nearest == 2) return met(probe2, probe_places[2], origin, d, level);
  return met(probe3, probe_places[3], origin, d, level);
}
// What a flat part mirrors: rgb, and how far it is open to what lies beyond the scene.
vec4 flat_picture(int facet) {
  float layer = facet_facts[facet].x;
  if (layer < 0.0) return vec4(0.0, 0.0, 0.0, 1.0);
  vec4 seen = texelFetch(pictures, ivec3(int(size.x) - 1 - int(gl_FragCoord.x), int(gl_FragCoord.y), int(layer + 0.5)), 0);
  return vec4(seen.rgb, 1.0 - seen.a);
}
vec3 encoded(vec3 l) {
  l = clamp(l, 0.0, 1.0);
  return mix(12.92 * l, 1.055 * pow(l, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, l));
}
vec3 depth_color(float x) {  // near is warm and bright
  return clamp(vec3(1.5 - 1.6 * x, 1.05 - 1.1 * x, 0.55 - 0.1 * x + 0.3 * x * x), 0.0, 1.0);
}

vec3 confidence_color(vec3 sum, float alpha) {
  float none = clamp(sum.y / alpha, 0.0, 1.0), x = 4.0 * clamp(sum.x / max(alpha - sum.y, 1e-4), 0.0, 1.0);
  int k = min(int(x), 3);
  return mix(mix(scale[k], scale[k + 1], x - float(k)), vec3(unseen), none);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 per_z = ray_per_z(pixel_of_fragment()), dir = normalize(per_z);
  Surface s = surface_of(at, per_z);
  Pane pane = pane_of(at, per_z, s);
  vec4 met_surfels = traced ? texelFetch(reflected, at, 0) : kNothing;
  bool by_pane = ray_by_pane(pane);
  vec3 outside = lit ? (background ? sky_radiance(dir, 0.0) : vec3(0.05)) : vec3(0.0), radiance = s.color;
  if (s.asks && (lit || pane.tau <= 0.0)) {
    vec4 met_by_it = by_pane ? kNothing : met_surfels;
    vec3 seen = lit ? met_by_it.rgb + met_by_it.a * mirrored(eye + s.z * per_z, reflect(dir, s.normal), s.roughness) : met_surfels.rgb;
    if (s.facet >= 0) {
      vec4 flat_seen = flat_picture(s.facet);
      seen = flat_seen.rgb + flat_seen.a * seen;
    }
    Weights w = layer_weights(s.f0, s.k_s, 0.0, lit ? max(s.cosine, 0.02) : s.cosine, s.agreement, s.coat, true, false);
    radiance = w.diffuse * s.color + (lit ? s.alpha : 1.0) * w.reflection * seen;
  }
  radiance += (1.0 - s.alpha) * outside;

  vec3 added = vec3(0.0);  // by the glass
  if (pane.tau > 0.0) {
    vec3 back = reflect(dir, pane.normal), behind = radiance;
    vec4 met_by_it = by_pane ? met_surfels : kNothing;
    vec3 beyond = met_by_it.rgb + (lit ? met_by_it.a * mirrored(eye + pane.z * per_z, back, 0.0) : vec3(0.0));
    bool is_flat = pane.near.there && pane.near.flat_;
    vec4 near_seen = is_flat ? flat_picture(pane.near.facet) : vec4(0.0, 0.0, 0.0, 1.0);
    vec3 c_r = near_seen.rgb + near_seen.a * beyond, c_t = behind, far_added = vec3(0.0);
    Part l = part(texelFetch(far_pane, at, 0));
    if (pane.near.there && l.there && l.flat_ && facet_facts[l.facet].y > 0.5 && l.z >= (1.0 + 1e-5) * pane.z) {
      float rise = dot(l.normal, per_z);
      if ((s.shown_z - l.z) * rise > facet_facts[l.facet].z) {
        vec4 far_seen = flat_picture(l.facet);
        vec3 p = fresnel(vec3(kPaneReflectance), rise / length(per_z), 1.0);
        far_added = p * (far_seen.rgb + far_seen.a * (lit ? mirrored(eye + l.z * per_z, reflect(dir, -l.normal), 0.0) : met_surfels.rgb));
        c_t = (1.0 - p) * c_t + far_added;
      }
    }
    Weights w = layer_weights(vec3(kPaneReflectance), kSheetSpecular, pane.tau, max(-dot(pane.normal, dir), 0.0), 1.0, false, lit || reflects || is_flat, true);
    radiance = w.diffuse * behind + w.reflection * c_r + w.transmission * c_t;
    added = w.reflection * c_r + w.transmission * far_added;
  }

  vec3 display = encoded(gain * radiance);
  if (show == 1) display = encoded(s.color + (1.0 - s.alpha) * vec3(0.05));
  if (show == 2) display = s.there ? 0.5 + 0.5 * s.normal : vec3(0.0);
  if (show == 3) display = s.there ? vec3(s.roughness) : vec3(0.0);
  if (show == 4) display = s.there ? depth_color(clamp((s.z - depth_range.x) / (depth_range.y - depth_range.x), 0.0, 1.0)) : vec3(0.0);
  if (show == 6) display = s.there ? confidence_color(s.color, s.alpha) : vec3(0.0);
  if (show == 5) display = encoded(gain * added);
  shown = vec4(display, 1.0);
}
