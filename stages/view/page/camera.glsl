// A pinhole camera of vitrine: x right, y down, z forward; pixel centres at .5, rows from the top.
uniform mat3 rotation;      // camera from world
uniform vec3 translation;
uniform vec3 eye;           // in world
uniform vec4 pinhole;       // fx, fy, cx, cy in pixels of the picture
uniform vec2 size;          // of the picture, pixels

vec4 clip_position(vec2 pixel, float z) {  // no depth: order is the caller's
  return vec4(2.0 * pixel.x / size.x - 1.0, 1.0 - 2.0 * pixel.y / size.y, 0.0, 1.0) * z;
}
#ifndef VERTEX
vec2 pixel_of_fragment() { return vec2(gl_FragCoord.x, size.y - gl_FragCoord.y); }
#endif
// From the eye, camera-z 1.
vec3 ray_per_z(vec2 pixel) { return vec3((pixel - pinhole.zw) / pinhole.xy, 1.0) * rotation; }
