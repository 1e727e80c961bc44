// The light around the scene, and what mirrors see of the scene (probes).
uniform sampler2D sky;             // lat-long, first row +z, centre +x, three quarters -y
uniform float sky_turn;            // radians about +z, counter-clockwise seen from above
uniform float sky_levels;          // of its mip chain

const float kPi = 3.141592653589793;

vec3 sky_radiance(vec3 d, float level) {
  float u = 0.5 - (atan(d.y, d.x) - sky_turn) / (2.0 * kPi), v = 0.5 - asin(clamp(d.z, -1.0, 1.0)) / kPi;
  return textureLod(sky, vec2(u, v), level).rgb;
}
vec3 octahedral_direction(vec2 uv) {
  vec2 p = 2.0 * uv - 1.0;
  float z = 1.0 - abs(p.x) - abs(p.y);
  if (z < 0.0) p = (1.0 - abs(p.yx)) * vec2(p.x < 0.0 ? -1.0 : 1.0, p.y < 0.0 ? -1.0 : 1.0);
  return normalize(vec3(p, z));
}
vec2 octahedral_place(vec3 d) {
  d /= abs(d.x) + abs(d.y) + abs(d.z);
  vec2 p = d.z < 0.0 ? (1.0 - abs(d.yx)) * vec2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0) : d.xy;
  return 0.5 * p + 0.5;
}
