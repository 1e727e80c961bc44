// Triangles of known shapes: x, y of the normal, z-depth, and which part: 1 + facet, or 10001 + entry of a curved one; negative
// where the z of the normal is. Nearest first, by the depth buffer.
precision highp float;
#ifdef VERTEX
uniform vec2 depths;  // nearest and farthest z
in vec3 position, normal;
in vec2 part;         // facet (65535: curved), entry
in vec2 kind;         // closed, clear
out vec3 place, outwards;
flat out vec2 which, how;
void main() {
  vec3 p = rotation * position + translation;
  place = position, outwards = normal, which = part, how = kind;
  vec2 pixel_z = pinhole.xy * p.xy + pinhole.zw * p.z;
  gl_Position = vec4(2.0 * pixel_z.x / size.x - p.z, p.z - 2.0 * pixel_z.y / size.y,
                     ((depths.x + depths.y) * p.z - 2.0 * depths.x * depths.y) / (depths.y - depths.x), p.z);
}
#else
uniform int side;  // 0: surfaces that face the eye, 1: panes likewise, 2: those that look away, of closed shapes
uniform vec4 clip;  // shown is where dot(clip.xyz, p) >= clip.w
in vec3 place, outwards;
flat in vec2 which, how;
out vec4 seen;
void main() {
  if (dot(clip.xyz, place) < clip.w) discard;
  vec3 n = normalize(outwards);
  bool faces = dot(n, eye - place) > 0.0, closed = how.x > 0.5;
  if (closed ? faces == (side == 2) : side == 2) discard;
  if (side == 1 && how.y < 0.5) discard;
  if (!faces && !closed) n = -n;
  float z = (rotation * place + translation).z, code = which.x < 65000.0 ? 1.0 + which.x : 10001.0 + which.y;
  seen = vec4(n.xy, z, n.z < 0.0 ? -code : code);
}
#endif
