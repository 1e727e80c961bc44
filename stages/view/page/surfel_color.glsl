// The colour of every surfel in one picture, a texel each: what it sends to the eye; and the normal that faces it.
precision highp float;
precision highp int;
precision highp sampler2D;

uniform sampler2D places;
uniform sampler2D turns;          // quaternion w x y z
uniform sampler2D weights;        // k_s, tau, of the picture
uniform sampler2D constants;      // colour without the harmonics
uniform sampler2D tints;          // of colours as photographed
uniform sampler2D sh;             // 16 texels a surfel, bytes about 128/255; scale in scales.x
uniform sampler2D scales;         // of sh, of albedo; confidence, 1 where no photo saw the surfel (confidence.js)
uniform sampler2D albedo;         // square root of
uniform sampler2D lit_materials;  // f0, roughness
uniform sampler2D lit_weights;    // k_s, tau
uniform sampler2D irradiance;     // of the light of now (irradiance.js)
uniform vec3 eye;
uniform int paint;                // 0 as photographed, 1 matt under the light, 2 albedo, 3 matt with what glossy surfaces return, 4 confidence
uniform int sh_count;             // coefficients beyond the constant
uniform int count;

uniform bool clear;               // tau stands in the place of k_s

layout(location = 0) out vec4 color;
layout(location = 1) out vec4 facing;  // normal, k_s

void main() {
  int width = textureSize(places, 0).x, i = int(gl_FragCoord.y) * width + int(gl_FragCoord.x);
  ivec2 at = ivec2(i % width, i / width);
  color = facing = vec4(0.0);
  if (i >= count) return;
  vec3 mean = texelFetch(places, at, 0).xyz;
  vec4 q = texelFetch(turns, at, 0);
  vec3 n = vec3(2.0 * (q.y * q.w + q.x * q.z), 2.0 * (q.z * q.w - q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
  vec2 w_of = texelFetch(weights, at, 0).xy;
  facing = vec4(dot(n, mean - eye) > 0.0 ? -n : n, clear ? w_of.y : w_of.x);
  float scale = texelFetch(scales, at, 0).x;
  if (paint == 0) {
    float y[16];
    basis(normalize(mean - eye), y);
    vec3 sum = texelFetch(constants, at, 0).rgb;
    for (int k = 0; k < sh_count; ++k) sum += y[k + 1] * scale * coefficient(sh, i, k, 63.0);
    color = vec4(max(sum, 0.0) * texelFetch(tints, at, 0).rgb, 1.0);
    return;
  }
  if (paint == 4) {
    color = vec4(texelFetch(scales, at, 0).zw, 0.0, 1.0);
    return;
  }
  vec3 paint_color = texelFetch(albedo, at, 0).rgb;
  paint_color *= paint_color * texelFetch(scales, at, 0).y;
  if (paint == 2) {
    color = vec4(paint_color, 1.0);
    return;
  }
  vec3 e = texelFetch(irradiance, at, 0).rgb;
  if (paint == 3) {
    Weights w = layer_weights(texelFetch(lit_materials, at, 0).rgb, texelFetch(lit_weights, at, 0).x, 0.0, 0.7, 1.0, false, true, true);
    paint_color = min(w.diffuse * paint_color + w.reflection, 1.0);
  }
  color = vec4(paint_color * e / 3.141592653589793, 1.0);
}
