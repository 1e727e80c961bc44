// What a pixel shows first: the opaque surface, and glass before it (core/model/README.md 1, 6).
precision highp float;
precision highp int;
precision highp sampler2D;

uniform sampler2D color_sum, normal_sum, f0_sum, depth_sum;  // of everything but the glass
uniform sampler2D glass_normal, glass_depth;                 // of glass whose shape is not known: sums; z, roughness, tau
uniform bool glass_surfels;
uniform sampler2D opaque_shape, near_pane, far_pane;         // of known shapes (shape.glsl)
uniform vec4 facet_facts[MOST_FACETS];                       // layer of `pictures` or -1, clear, at_pane, entry
uniform vec4 entries[MOST_ENTRIES];                          // tolerance, role (0 mirror, 1 sheet, 2 coat), exact, closed
uniform bool reflects;  // the scene has a reflection layer
uniform bool lit;       // under another light
uniform bool panes;     // glass is shown

const float kSurface = 0.5;        // coverage from which on there is a surface
const float kPolished = 0.3;
const float kFrameSpecular = 0.1;
const float kBehind = 36.7;        // tolerances that a mirror's far side may lie behind (core/model/shape_pass.cpp)
const float kBehindCoat = 4.0;
const float kFar = 1e9;
const float kAsks = 1.0 / 255.0;

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
float agreement_of(vec3 sum, float alpha) {
  float x = clamp((length(sum) / alpha - 0.5) / 0.3, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

struct Surface {
  vec3 color;        // sum
  float alpha;
  vec3 normal, f0;
  float z, roughness, k_s, agreement, cosine;
  bool there, coat, asks;  // asks: it mirrors
  int facet;         // of a flat mirror, or -1
  float shown_z;     // where the surfels stand
};
struct Pane { float tau, z; vec3 normal; Part near; };

Surface surface_of(ivec2 at, vec3 per_z) {
  vec4 c = texelFetch(color_sum, at, 0), n_sum = texelFetch(normal_sum, at, 0), d = texelFetch(depth_sum, at, 0);
  float speed = length(per_z), inv = c.a > 0.0 ? 1.0 / c.a : 0.0;
  vec3 dir = per_z / speed;
  Surface s;
  s.color = c.rgb, s.alpha = c.a;
  s.normal = length(n_sum.xyz) > 0.0 ? normalize(n_sum.xyz) : -dir;
  s.f0 = texelFetch(f0_sum, at, 0).rgb * inv;
  s.z = d.x * inv, s.roughness = clamp(d.y * inv, 0.03, 1.0), s.k_s = lit ? d.z * inv : d.z;
  s.agreement = c.a > 0.0 ? agreement_of(n_sum.xyz, c.a) : 0.0;
  s.there = c.a > kSurface, s.coat = false, s.facet = -1;
  s.shown_z = s.there && s.z > 0.0 ? s.z : kFar;
  Part o = part(texelFetch(opaque_shape, at, 0));
  if (s.there && o.there && dot(o.normal, dir) < 0.0) {
    vec4 e = entries[o.entry];
    float in_front = (o.z - s.z) * speed;
    bool is_coat = e.y > 1.5;
    if (in_front <= e.x && in_front >= -(is_coat ? kBehindCoat : kBehind) * e.x && (is_coat || lit || d.z > kPolished * c.a)) {
      s.coat = is_coat;
      if (!is_coat || e.z > 0.5) s.normal = o.normal, s.z = o.z, s.agreement = 1.0;
      if (!is_coat && o.flat_) s.facet = o.facet;
    }
  }
  s.cosine = -dot(s.normal, dir);
  s.asks = lit ? c.a > kAsks : reflects && s.there && (s.k_s > kAsks || s.coat) && s.cosine > 0.0;
  return s;
}

// Whether the ray of a pixel (mirror_rays.glsl) is that of the pane; else it is that of what stands behind it.
bool ray_by_pane(Pane p) { return p.tau > 0.0 && !(lit && p.near.there && p.near.flat_ && facet_facts[p.near.facet].x >= 0.0); }

Pane pane_of(ivec2 at, vec3 per_z, Surface s) {
  Pane p;
  p.tau = 0.0;
  if (!panes) return p;
  p.near = part(texelFetch(near_pane, at, 0));
  if (p.near.there) {
    float tolerance = entries[p.near.entry].x;
    bool is_frame = reflects && texelFetch(depth_sum, at, 0).z > kFrameSpecular;
    if ((s.shown_z - p.near.z) * length(per_z) <= (is_frame ? tolerance : -tolerance)) p.near.there = false;
  }
  if (p.near.there) p.tau = 1.0, p.normal = p.near.normal, p.z = p.near.z;
  else if (glass_surfels) {
    vec4 g = texelFetch(glass_normal, at, 0), gd = texelFetch(glass_depth, at, 0);
    if (g.a > 0.02 && s.shown_z > gd.x / g.a) p.tau = min(gd.z, 1.0), p.normal = normalize(g.xyz), p.z = gd.x / g.a;
  }
  return p;
}
