#version 300 es
// Rays through the volume, front to back: colours and opacities of the transfer function, lit by the gradient. Lengths in units of the scan.
precision highp float;
precision highp sampler3D;
uniform sampler3D volume;     // densities, 0 to 1
uniform sampler3D blocks;     // not 0 where a block of voxels may be seen
uniform sampler2D transfer;   // row 0: colour; row 1: opacity
uniform vec3 low, high, end;  // of the voxels; end: of the scan
uniform float radius, cell;   // of the cylinder that the scan shows, or negative
uniform vec3 eye, ahead, right, up;  // right and up: to the borders of the picture at distance 1
uniform float jump, layer;    // length of a step; length that the opacities refer to
uniform vec4 cut;             // visible: dot(cut.xyz, p) >= cut.w
uniform bool lit;
uniform vec2 grey;             // densities that are black and white on the cut
uniform vec3 ground;
uniform vec2 size;
out vec4 color;

const int kMostSteps = 4096;
const float kOpaque = 0.985, kBlock = 8.0;

float density(vec3 p) { return texture(volume, (p - low) / (high - low)).r; }

vec3 gradient(vec3 p) {
  vec2 d = vec2(1.5 * cell, 0);
  return vec3(density(p + d.xyy) - density(p - d.xyy), density(p + d.yxy) - density(p - d.yxy), density(p + d.yyx) - density(p - d.yyx));
}

vec4 seen(float q) {
  float n = float(textureSize(transfer, 0).x), x = (q * (n - 1.0) + 0.5) / n;
  return vec4(texture(transfer, vec2(x, 0.25)).rgb, texture(transfer, vec2(x, 0.75)).r);
}

// Narrows [from, to] to where the ray is in the box of the scan, in the cylinder and on the visible side of the cut. Returns true if it
// enters through the cut.
bool narrow(vec3 way, inout float from, inout float to) {
  vec3 a = (low - eye) / way, b = (end - eye) / way, near = min(a, b), far = max(a, b);
  from = max(from, max(near.x, max(near.y, near.z))), to = min(to, min(far.x, min(far.y, far.z)));
  if (radius > 0.0) {
    float uu = dot(way.xy, way.xy), ou = dot(eye.xy, way.xy), c = dot(eye.xy, eye.xy) - radius * radius, inside = ou * ou - uu * c;
    if (uu < 1e-12) to = c > 0.0 ? -1.0 : to;
    else if (inside < 0.0) to = -1.0;
    else from = max(from, (-ou - sqrt(inside)) / uu), to = min(to, (-ou + sqrt(inside)) / uu);
  }
  float height = dot(cut.xyz, eye) - cut.w, slope = dot(cut.xyz, way);
  if (abs(slope) < 1e-12) {
    if (height < 0.0) to = -1.0;
    return false;
  }
  float at = -height / slope;
  bool enters = slope > 0.0 && at > from;
  if (slope > 0.0) from = max(from, at);
  else to = min(to, at);
  return enters;
}

float noise(vec2 p) { return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715)))); }

vec3 shaded(vec3 base, vec3 p, vec3 way) {
  vec3 g = gradient(p), light = normalize(-ahead + 0.45 * up / length(up) - 0.35 * right / length(right));
  float steep = length(g);
  vec3 n = g / max(steep, 1e-6);
  float facing = abs(dot(n, light)), shine = pow(abs(dot(n, normalize(light - way))), 24.0), surface = smoothstep(0.002, 0.03, steep);
  return mix(0.8 * base, base * (0.28 + 0.78 * facing) + 0.1 * shine, surface);
}

void main() {
  vec2 at = 2.0 * gl_FragCoord.xy / size - 1.0;
  vec3 way = normalize(ahead + at.x * right + at.y * up);
  way += vec3(lessThan(abs(way), vec3(1e-7))) * 1e-7;
  float from = 0.0, to = 1e30;
  bool on_cut = narrow(way, from, to);
  vec3 sum = vec3(0);
  float left = 1.0, t = from + (on_cut ? 0.01 : noise(gl_FragCoord.xy)) * jump;
  vec3 side = cell * kBlock * sign(way);
  for (int i = 0; i < kMostSteps && t < to && left > 1.0 - kOpaque; ++i) {
    vec3 p = eye + t * way;
    if (texelFetch(blocks, clamp(ivec3((p - low) / (cell * kBlock)), ivec3(0), textureSize(blocks, 0) - 1), 0).r == 0.0) {
      vec3 corner = low + cell * kBlock * floor((p - low) / (cell * kBlock)), exits = (corner + max(sign(way), 0.0) * cell * kBlock - p) / way;
      t += max(ceil(min(exits.x, min(exits.y, exits.z)) / jump), 1.0) * jump;  // stays on the lattice of steps
      on_cut = false;
      continue;
    }
    float q = density(p);
    vec4 c = seen(q);
    if (c.a > 0.0) {
      float a = 1.0 - pow(max(1.0 - c.a, 1e-4), jump / layer);
      vec3 base = c.rgb;
      if (lit && on_cut) a = max(a, c.a), base *= 0.15 + 0.85 * clamp((q - grey.x) / (grey.y - grey.x), 0.0, 1.0);
      else if (lit && c.a > 0.002) base = shaded(c.rgb, p, way);
      sum += left * a * base;
      left *= 1.0 - a;
    }
    on_cut = false;
    t += jump;
  }
  color = vec4(sum + left * ground, 1);
}
