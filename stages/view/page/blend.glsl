// Fresnel reflectance and the blend of the layers: core/model/kernels/{fresnel,layer_blend}.h.
uniform bool layered;  // false: the blend rtrgs

const float kPaneReflectance = 0.07692307692307693;  // 2R/(1+R), R = 0.04
const float kMinSpecular = 1.0 / 255.0;
const float kFullFresnel = 0.05;
const float kFullClear = 0.001;

struct Weights { vec3 diffuse, reflection, transmission; };

float schlick_grazing(float c) { float x = 1.0 - clamp(c, 0.0, 1.0); return x * x * x * x * x; }
float sheet_grazing(float c) {
  if (c <= 0.0) return 1.0;
  if (c >= 1.0) return 0.0;
  float w = sqrt(1.25 + c * c), s = (c - w) / (c + w), p = (2.25 * c - w) / (2.25 * c + w), R = 0.5 * (s * s + p * p);
  return (2.0 * R / (1.0 + R) - kPaneReflectance) / (1.0 - kPaneReflectance);
}
vec3 fresnel(vec3 f0, float c, float clear) {
  float q = mix(schlick_grazing(c), sheet_grazing(c), clear);
  return f0 + (1.0 - f0) * q;
}
Weights layer_weights(vec3 f0, float k_s, float tau, float c, float agreement, bool coat, bool reflects, bool transmits) {
  if (!transmits) tau = 0.0;
  vec3 F = reflects ? fresnel(f0, c, tau) : vec3(0.0);
  if (!layered) {
    float k = agreement * k_s;
    return Weights(vec3(1.0 - k), k * F, k * tau * (1.0 - F));
  }
  float x = (k_s - kMinSpecular) / (kFullFresnel - kMinSpecular);
  float g = coat ? 1.0 : x <= 0.0 ? 0.0 : x < 1.0 ? x * (2.0 - x) : 1.0, y = k_s / kFullClear;
  float gate = g + (1.0 - g) * tau * (y < 1.0 ? y * y * (3.0 - 2.0 * y) : 1.0);
  vec3 k = reflects ? agreement * (k_s + (1.0 - k_s) * gate * F) : vec3(0.0);
  return Weights((1.0 - k) * (1.0 - tau), k, (1.0 - k) * tau);
}
