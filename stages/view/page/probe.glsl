// One probe under the light of now: radiance, and the distance of what sends it (1e4: the sky).
precision highp float;
precision highp int;
precision highp sampler2D;

uniform sampler2D constants;  // of the transfer, and how far the direction is open
uniform sampler2D shapes;     // its other coefficients: four texels of four bytes
uniform sampler2D depths;
uniform vec3 light[16];
uniform float steps;
uniform int row;              // where the probe begins
uniform int side;

out vec4 seen;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), from = at + ivec2(0, row);
  vec4 constant = texelFetch(constants, from, 0);
  vec3 e = light[0];
  for (int k = 0; k < 15; ++k)
    e += light[k + 1] * (texelFetch(shapes, ivec2(4 * from.x + k / 4, from.y), 0)[k % 4] * 255.0 - 128.0) / steps;
  float depth = texelFetch(depths, from, 0).r;
  seen = vec4(constant.rgb * max(e, 0.0) + constant.a * sky_radiance(octahedral_direction((vec2(at) + 0.5) / float(side)), 0.0), depth > 0.0 ? depth : 1e4);
}
