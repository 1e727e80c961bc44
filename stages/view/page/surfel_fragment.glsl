// The surfels of a pixel, blended front to back in the order of their depths (core/render/README.md 3 to 5). The list of the pixel's
// tile is nearly in that order; what passes the last kWindow of it is.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

uniform usampler2D lists;           // surfels, tile by tile, nearest first
uniform usampler2D starts;          // where the list of a tile begins
uniform ivec4 tiles;                // side in pixels, tiles in a row, left, top of the first
uniform ivec2 tile_rows;            // rows of tiles
uniform sampler2D maps;             // three texels a surfel: middle, z0, opacity; m00 m01 m10 m11; h0 h1 (order.js)
uniform sampler2D colors, facings;  // surfel_color.glsl
uniform sampler2D materials;        // f0, roughness
uniform float near_z;
uniform vec4 clip;                  // shown is where dot(clip.xyz, p) >= clip.w

layout(location = 0) out vec4 color_sum;
#ifdef SURFACE
layout(location = 1) out vec4 normal_sum;
layout(location = 2) out vec4 f0_sum;
layout(location = 3) out vec4 depth_sum;  // z, roughness, k_s
#endif

const float kMinAlpha = 1.0 / 255.0;
const float kMaxAlpha = 0.99;
const float kMinTransmittance = 1e-4;
const int kWindow = 12;

ivec2 texel(int i, int width) { return ivec2(i % width, i / width); }

float light = 1.0;  // from behind

void blend(float z, float alpha, int surfel) {
  if (light < kMinTransmittance) return;
  float w = alpha * light;
  light *= 1.0 - alpha;
  ivec2 at = texel(surfel, textureSize(colors, 0).x);
  color_sum += vec4(w * texelFetch(colors, at, 0).rgb, w);
#ifdef SURFACE
  vec4 facing = texelFetch(facings, at, 0), material = texelFetch(materials, at, 0);
  normal_sum += vec4(w * facing.xyz, w);
  f0_sum += vec4(w * material.rgb, w);
  depth_sum += w * vec4(z, material.a, facing.w, 1.0);
#endif
}

void main() {
  color_sum = vec4(0.0);
#ifdef SURFACE
  normal_sum = f0_sum = depth_sum = vec4(0.0);
#endif
  vec2 pixel = pixel_of_fragment();
  ivec2 tile = (ivec2(pixel) - tiles.zw) / tiles.x;
  if (any(lessThan(ivec2(pixel), tiles.zw)) || tile.x >= tiles.y || tile.y >= tile_rows.x) return;
  int starts_width = textureSize(starts, 0).x, lists_width = textureSize(lists, 0).x, maps_width = textureSize(maps, 0).x;
  int number = tile.y * tiles.y + tile.x;
  int first = int(texelFetch(starts, texel(number, starts_width), 0).r), last = int(texelFetch(starts, texel(number + 1, starts_width), 0).r);

  float clip_rise = dot(clip.xyz, ray_per_z(pixel)), clip_start = dot(clip.xyz, eye) - clip.w;
  float zs[kWindow], alphas[kWindow];
  int surfels[kWindow];  // farthest first
  for (int k = 0; k < kWindow; ++k) zs[k] = -1.0, alphas[k] = 0.0, surfels[k] = 0;
  for (int i = first; i < last && light >= kMinTransmittance; ++i) {
    int surfel = int(texelFetch(lists, texel(i, lists_width), 0).r);
    vec4 middle = texelFetch(maps, texel(3 * surfel, maps_width), 0);
    vec4 map = texelFetch(maps, texel(3 * surfel + 1, maps_width), 0);
    vec2 slope = texelFetch(maps, texel(3 * surfel + 2, maps_width), 0).xy, d = pixel - middle.xy;
    float inv_den = 1.0 / (1.0 + dot(slope, d));
    vec2 uv = vec2(dot(map.xy, d), dot(map.zw, d)) * inv_den;
    float plane = dot(uv, uv), dot2 = 2.0 * dot(d, d);
    bool on_plane = plane <= dot2 && inv_den * middle.z >= near_z;
    float alpha = min(middle.w * exp(-0.5 * (on_plane ? plane : dot2)), kMaxAlpha);
    if (!(alpha >= kMinAlpha)) continue;
    float z = middle.z * (on_plane ? inv_den : 1.0);
    if (clip_start + z * clip_rise < 0.0) continue;
    for (int k = 0; k < kWindow; ++k) {
      if (z > zs[k]) {
        float z_k = zs[k], alpha_k = alphas[k];
        int surfel_k = surfels[k];
        zs[k] = z, alphas[k] = alpha, surfels[k] = surfel;
        z = z_k, alpha = alpha_k, surfel = surfel_k;
      }
    }
    if (alpha > 0.0) blend(z, alpha, surfel);
  }
  for (int k = kWindow - 1; k >= 0; --k)
    if (alphas[k] > 0.0) blend(zs[k], alphas[k], surfels[k]);
}
