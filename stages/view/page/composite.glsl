// From the blended channels to the picture: core/model/README.md 1, 2, 4 and 6 as photographed, core/relight/README.md 1 under
// another light. One pass over the screen.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;

uniform sampler2D color_sum, normal_sum, f0_sum, depth_sum;  // of everything but the glass
uniform sampler2D glass_normal, glass_depth;                 // of glass whose shape is not known: sums; z, roughness, tau
uniform bool glass_surfels;
uniform sampler2D opaque_shape, near_pane, far_pane;         // of known shapes
uniform sampler2DArray pictures;                             // what flat panes and mirrors show, turned left to right
uniform vec4 facet_facts[MOST_FACETS];                       // layer of `pictures` or -1, clear, at_pane, entry
uniform vec4 entries[MOST_ENTRIES];                          // tolerance, role (0 mirror, 1 sheet, 2 coat), exact, closed
uniform sampler2D probe0, probe1, probe2, probe3;            // radiance, distance
uniform vec3 probe_places[4];
uniform int probe_count;
uniform float probe_levels;
uniform bool reflects;      // the scene has a reflection layer
uniform bool rough;         // reflections widen with the roughness
uniform bool lit;           // under another light
uniform bool panes;         // sheets of glass are shown
uniform bool background;
uniform int show;           // 0 picture, 1 albedo, 2 normals, 3 roughness, 4 depth, 5 what the glass adds
uniform vec3 gain;
uniform vec2 depth_range;

out vec4 shown;

const float kSurface = 0.5;        // coverage from which on there is a surface
const float kPolished = 0.3;
const float kFrameSpecular = 0.1;
const float kSheetSpecular = 0.002;
const float kBehind = 36.7;        // tolerances that a mirror's far side may lie behind (core/model/shape_pass.cpp)
const float kBehindCoat = 4.0;
const float kFar = 1e9;

struct Part { bool there, flat_; int facet, entry; vec3 normal; float z; };
Part part(vec4 seen) {
  float code = abs(seen.w);
  Part p = Part(code > 0.5, code < 10000.0, -1, 0, vec3(0.0), seen.z);
  if (!p.there) return p;
  p.facet = p.flat_ ? int(code + 0.5) - 1 : -1;
  p.entry = p.flat_ ? int(facet_facts[p.facet].w + 0.5) : int(code + 0.5) - 10001;
  p.normal = vec3(seen.xy, sqrt(max(0.0, 1.0 - dot(seen.xy, seen.xy))) * sign(seen.w));
  return p;
}

// Along the ray until it is as far from the middle of the probe as what is seen in that direction.
vec3 met(sampler2D probe, vec3 centre, vec3 origin, vec3 d, float level) {
  vec3 q = origin - centre, to = d;
  float b = dot(q, d), qq = dot(q, q);
  for (int i = 0; i < 6; ++i) {
    float r = textureLod(probe, octahedral_place(to), 0.0).a;
    if (r <= 0.0) r = 1e4;
    to = normalize(q + (sqrt(max(b * b - qq + r * r, 0.0)) - b) * d);
  }
  return textureLod(probe, octahedral_place(to), level).rgb;
}
vec3 mirrored(vec3 origin, vec3 d, float roughness) {
  int nearest = 0;
  for (int i = 1; i < probe_count; ++i)
    if (distance(origin, probe_places[i]) < distance(origin, probe_places[nearest])) nearest = i;
  float level = probe_levels * min(1.0, 1.2 * roughness);
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
float agreement_of(vec3 sum, float alpha) {
  float x = clamp((length(sum) / alpha - 0.5) / 0.3, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}
vec3 encoded(vec3 l) {
  l = clamp(l, 0.0, 1.0);
  return mix(12.92 * l, 1.055 * pow(l, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, l));
}
vec3 depth_color(float x) {  // near is warm and bright
  return clamp(vec3(1.5 - 1.6 * x, 1.05 - 1.1 * x, 0.55 - 0.1 * x + 0.3 * x * x), 0.0, 1.0);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 c = texelFetch(color_sum, at, 0), n_sum = texelFetch(normal_sum, at, 0), f = texelFetch(f0_sum, at, 0),
       d = texelFetch(depth_sum, at, 0);
  vec3 per_z = ray_per_z(pixel_of_fragment()), dir = normalize(per_z);
  float speed = length(per_z), alpha = c.a, inv = alpha > 0.0 ? 1.0 / alpha : 0.0;
  vec3 outside = lit ? (background ? sky_radiance(dir, 0.0) : vec3(0.05)) : vec3(0.0);

  // The opaque surface.
  vec3 normal = length(n_sum.xyz) > 0.0 ? normalize(n_sum.xyz) : -dir, f0 = f.rgb * inv;
  float z = d.x * inv, roughness = clamp(d.y * inv, 0.03, 1.0), k_s = lit ? d.z * inv : d.z;
  float agreement = alpha > 0.0 ? agreement_of(n_sum.xyz, alpha) : 0.0;
  bool surface = alpha > kSurface, coat = false;
  int mirror_facet = -1;
  Part o = part(texelFetch(opaque_shape, at, 0));
  if (surface && o.there && dot(o.normal, dir) < 0.0) {
    vec4 e = entries[o.entry];
    float in_front = (o.z - z) * speed;
    bool is_coat = e.y > 1.5;
    if (in_front <= e.x && in_front >= -(is_coat ? kBehindCoat : kBehind) * e.x && (is_coat || d.z > kPolished * alpha)) {
      coat = is_coat;
      if (!is_coat || e.z > 0.5) normal = o.normal, z = o.z, agreement = 1.0;
      if (!is_coat && o.flat_) mirror_facet = o.facet;
    }
  }
  float cosine = -dot(normal, dir);
  vec3 radiance = c.rgb, place = eye + z * per_z;
  bool asks = lit ? alpha > 1.0 / 255.0 : reflects && surface && (k_s > kMinSpecular || coat) && cosine > 0.0;
  if (asks) {
    if (lit) cosine = max(cosine, 0.02);
    vec3 seen = mirrored(place, reflect(dir, normal), rough || lit ? roughness : 0.0);
    if (mirror_facet >= 0) {
      vec4 flat_seen = flat_picture(mirror_facet);
      seen = flat_seen.rgb + flat_seen.a * seen;
    }
    Weights w = layer_weights(f0, k_s, 0.0, cosine, agreement, coat, true, false);
    radiance = w.diffuse * c.rgb + (lit ? alpha : 1.0) * w.reflection * seen;
  }
  radiance += (1.0 - alpha) * outside;

  // Glass before it.
  vec3 behind = radiance, added = vec3(0.0);
  float tau = 0.0;
  if (panes) {
    Part s = part(texelFetch(near_pane, at, 0));
    float shown_z = surface && z > 0.0 ? d.x * inv : kFar;
    if (s.there) {
      float tolerance = entries[s.entry].x;
      if ((shown_z - s.z) * speed <= (reflects && d.z > kFrameSpecular ? tolerance : -tolerance)) s.there = false;
    }
    vec3 n = s.normal;
    float near_z = s.z;
    tau = s.there ? 1.0 : 0.0;
    if (!s.there && glass_surfels) {
      vec4 g = texelFetch(glass_normal, at, 0), gd = texelFetch(glass_depth, at, 0);
      if (g.a > 0.02 && (shown_z - gd.x / g.a) * speed > 0.0) {
        tau = min(gd.z, 1.0), n = normalize(g.xyz), near_z = gd.x / g.a;
        s.flat_ = false;
      }
    }
    if (tau > 0.0) {
      float c_n = max(-dot(n, dir), 0.0);
      vec3 at_pane = eye + near_z * per_z, back = reflect(dir, n);
      vec3 far_light = lit ? sky_radiance(back, 0.0) : mirrored(at_pane, back, 0.0);
      vec4 near_seen = s.there && s.flat_ ? flat_picture(s.facet) : vec4(mirrored(at_pane, back, 0.0), 0.0);
      vec3 c_r = near_seen.rgb + near_seen.a * far_light, c_t = behind, far_added = vec3(0.0);
      Part l = part(texelFetch(far_pane, at, 0));
      if (s.there && l.there && l.flat_ && facet_facts[l.facet].y > 0.5 && l.z >= (1.0 + 1e-5) * near_z) {
        float rise = dot(l.normal, per_z);
        if ((shown_z - l.z) * rise > facet_facts[l.facet].z) {
          vec4 far_seen = flat_picture(l.facet);
          vec3 p = fresnel(vec3(kPaneReflectance), rise / speed, 1.0);
          vec3 inner = lit ? sky_radiance(reflect(dir, -l.normal), 0.0) : far_light;
          far_added = p * (far_seen.rgb + far_seen.a * inner);
          c_t = (1.0 - p) * c_t + far_added;
        }
      }
      Weights w = layer_weights(vec3(kPaneReflectance), kSheetSpecular, tau, c_n, 1.0, false, lit || reflects || s.flat_, true);
      radiance = w.diffuse * behind + w.reflection * c_r + w.transmission * c_t;
      added = w.reflection * c_r + w.transmission * far_added;
    }
  }

  vec3 display = encoded(gain * radiance);
  if (show == 1) display = encoded(c.rgb + (1.0 - alpha) * vec3(0.05));
  if (show == 2) display = surface ? 0.5 + 0.5 * normal : vec3(0.0);
  if (show == 3) display = surface ? vec3(roughness) : vec3(0.0);
  if (show == 4) display = surface ? depth_color(clamp((z - depth_range.x) / (depth_range.y - depth_range.x), 0.0, 1.0)) : vec3(0.0);
  if (show == 5) display = encoded(gain * added);
  shown = vec4(display, 1.0);
}
