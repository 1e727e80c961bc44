// One probe under the light of now: radiance, and the distance of what shows it (1e4: the sky).
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;

uniform usampler2D surfels;   // which surfel a direction shows; all ones: none
uniform sampler2D depths;
uniform sampler2D colors;     // of the surfels
uniform int row;              // where the probe begins in both
uniform int side;

out vec4 seen;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  uint i = texelFetch(surfels, at + ivec2(0, row), 0).r;
  if (i != 0xffffffffu) {
    int width = textureSize(colors, 0).x;
    vec4 color = texelFetch(colors, ivec2(int(i) % width, int(i) / width), 0);
    if (color.a > 0.5) {
      seen = vec4(color.rgb, texelFetch(depths, at + ivec2(0, row), 0).r);
      return;
    }
  }
  seen = vec4(sky_radiance(octahedral_direction((vec2(at) + 0.5) / float(side)), 0.0), 1e4);
}
