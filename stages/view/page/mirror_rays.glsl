// What pixels mirror: one ray each, through a tree of surfels (tree.js), as core/trace/README.md 1 and 3. They are those of the reflection
// layer; LIT: the opaque ones, with what they send on under the light.
// a: what lies behind all of it.
precision highp usampler2D;

uniform sampler2D nodes;
uniform usampler2D items;
uniform int node_count;
uniform sampler2D places, turns, spans;  // of surfels
#ifdef LIT
uniform sampler2D colors;
#else
uniform sampler2D constants, sh, scales;
uniform int sh_count;
#endif
uniform float reflection_near;

out vec4 reflected;

const float kMinAlpha = 1.0 / 255.0, kMaxAlpha = 0.99, kMinTransmittance = 1e-3, kGrazing = 1e-3;
const int kWindow = 16, kStack = 24;
#ifdef LIT
const int kRays = 12;                           // of a lobe
const float kSmooth = 0.06, kMatt = 0.6;        // roughness: one ray; a probe is as good
const float kGolden = 2.39996323;
#endif

ivec2 texel(int i, int width) { return ivec2(i % width, i / width); }

float light = 1.0;
vec3 sum = vec3(0.0);
#ifndef LIT
float harmonics[16];
#endif

void blend(float alpha, int surfel) {
  if (light < kMinTransmittance) return;
#ifdef LIT
  vec3 color = texelFetch(colors, texel(surfel, textureSize(colors, 0).x), 0).rgb;
#else
  ivec2 at = texel(surfel, textureSize(constants, 0).x);
  float scale = texelFetch(scales, at, 0).x;
  vec3 color = texelFetch(constants, at, 0).rgb;
  for (int k = 0; k < sh_count; ++k) color += harmonics[k + 1] * scale * coefficient(sh, surfel, k, 63.0);
#endif
  sum += alpha * light * max(color, 0.0);
  light *= 1.0 - alpha;
}

// rgb: what the ray meets; a: how far it is open to what lies beyond.
vec4 met(vec3 o, vec3 d) {
  vec3 inv = 1.0 / d;
  light = 1.0, sum = vec3(0.0);
#ifndef LIT
  basis(d, harmonics);
#endif

  float ts[kWindow], alphas[kWindow];
  int surfels[kWindow];  // farthest first
  for (int k = 0; k < kWindow; ++k) ts[k] = -1.0, alphas[k] = 0.0, surfels[k] = 0;
  int stack[kStack], top = 0, node = 0, nodes_width = textureSize(nodes, 0).x, items_width = textureSize(items, 0).x;
  int places_width = textureSize(places, 0).x;
  while (light >= kMinTransmittance) {
    vec4 low = texelFetch(nodes, texel(2 * node, nodes_width), 0), high = texelFetch(nodes, texel(2 * node + 1, nodes_width), 0);
    vec3 a = (low.xyz - o) * inv, b = (high.xyz - o) * inv, lesser = min(a, b), greater = max(a, b);
    float enters = max(max(lesser.x, lesser.y), max(lesser.z, reflection_near)), leaves = min(min(greater.x, greater.y), greater.z);
    if (enters <= leaves && high.w < 0.0) {
      int axis = int(-high.w - 0.5), right = int(low.w + 0.5);
      bool backwards = d[axis] < 0.0;
      stack[top++] = backwards ? node + 1 : right;
      node = backwards ? right : node + 1;
      continue;
    }
    if (enters <= leaves) {
      for (int i = int(low.w + 0.5), end = i + int(high.w + 0.5); i < end; ++i) {
        int surfel = int(texelFetch(items, texel(i, items_width), 0).r);
        ivec2 of = texel(surfel, places_width);
        vec4 place = texelFetch(places, of, 0), q = texelFetch(turns, of, 0);
        vec2 span = texelFetch(spans, of, 0).xy;
        vec3 r0 = vec3(1.0 - 2.0 * (q.z * q.z + q.w * q.w), 2.0 * (q.y * q.z + q.x * q.w), 2.0 * (q.y * q.w - q.x * q.z));
        vec3 r1 = vec3(2.0 * (q.y * q.z - q.x * q.w), 1.0 - 2.0 * (q.y * q.y + q.w * q.w), 2.0 * (q.z * q.w + q.x * q.y));
        vec3 n = cross(r0, r1);
        float slant = dot(n, d), t = dot(n, place.xyz - o) / slant;
        if (abs(slant) < kGrazing || !(t > reflection_near)) continue;
        vec3 x = o + t * d - place.xyz;
        float u = dot(r0, x) / span.x, v = dot(r1, x) / span.y, alpha = min(kMaxAlpha, place.w * exp(-0.5 * (u * u + v * v)));
        if (!(alpha >= kMinAlpha)) continue;
        for (int k = 0; k < kWindow; ++k)
          if (t > ts[k]) {
            float t_k = ts[k], alpha_k = alphas[k];
            int surfel_k = surfels[k];
            ts[k] = t, alphas[k] = alpha, surfels[k] = surfel;
            t = t_k, alpha = alpha_k, surfel = surfel_k;
          }
        if (alpha > 0.0) blend(alpha, surfel);
      }
    }
    if (top == 0) break;
    node = stack[--top];
  }
  for (int k = kWindow - 1; k >= 0; --k)
    if (alphas[k] > 0.0) blend(alphas[k], surfels[k]);
  return vec4(sum, light);
}

#ifdef LIT
// The mean over the lobe of a GGX surface: normals of facets by their density, at equal steps of it, turned from pixel to pixel.
vec4 met_by_lobe(vec3 o, vec3 dir, vec3 n, float roughness) {
  if (roughness < kSmooth) return met(o, reflect(dir, n));
  vec3 side = normalize(cross(n, abs(n.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0))), up = cross(n, side);
  float turn = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));  // interleaved gradient noise (Jimenez 2014)
  vec4 all = vec4(0.0);
  for (int i = 0; i < kRays; ++i) {
    float u = (float(i) + 0.5) / float(kRays), phi = kGolden * float(i) + 6.2831853 * turn, slope = roughness * roughness * sqrt(u / (1.0 - u));
    vec3 d = reflect(dir, normalize(n + slope * (cos(phi) * side + sin(phi) * up)));
    all += met(o, dot(d, n) > 0.0 ? d : reflect(dir, n));
  }
  return all / float(kRays);
}
#endif

void main() {
  reflected = vec4(0.0, 0.0, 0.0, 1.0);
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 per_z = ray_per_z(pixel_of_fragment()), dir = normalize(per_z);
  Surface s = surface_of(at, per_z);
  Pane p = pane_of(at, per_z, s);
  bool by_pane = ray_by_pane(p);
  if (node_count == 0 || (!by_pane && !s.asks)) return;
  vec3 o = eye + (by_pane ? p.z : s.z) * per_z, n = by_pane ? p.normal : s.normal;
#ifdef LIT
  if (!by_pane && s.facet >= 0 && facet_facts[s.facet].x >= 0.0) return;  // has a picture
  if (!by_pane && (s.roughness > kMatt || max(s.k_s, max(s.f0.x, max(s.f0.y, s.f0.z))) < kPolished)) return;
  reflected = met_by_lobe(o, dir, n, by_pane ? 0.0 : s.roughness);
#else
  reflected = met(o, reflect(dir, n));
#endif
}
