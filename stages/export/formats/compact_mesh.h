// A mesh as graphics cards like it: triangles in the order of their vertex cache and without much overdraw, vertices in the order
// of their first use (both by meshoptimizer), and attributes as short integers (KHR_mesh_quantization of glTF):
//   position  16 bits a coordinate of the cube around the mesh: at most 8e-6 of its side off
//   normal    16 bits, tangent 8 bits, of [-1, 1]
//   uv        16 bits of [0, 1]: at most 0.02 texels of a texture of 2048 off
// Same mesh: same bytes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

using Triangles = std::vector<std::array<uint32_t, 3>>;

struct CompactMesh {
  std::vector<uint16_t> positions;  // [n,3] (p - origin) / side in 65535ths
  std::vector<int16_t> normals;     // [n,3] in 32767ths
  std::vector<int8_t> tangents;     // [n,4] in 127ths, the fourth the handedness of the bitangent
  std::vector<uint16_t> uv;         // [n,2] in 65535ths
  std::vector<Triangles> parts;     // as they were given, of vertices of this mesh
  Vec3f origin{};
  float side = 1;

  size_t vertex_count() const { return positions.size() / 3; }
};

struct PlainMesh {
  std::span<const Vec3f> positions, normals, tangents;  // [vertices] normals and tangents unit, bitangent = normal x tangent
  std::span<const Vec2f> uv;                            // [vertices] within [0, 1]
  std::span<const Triangles> parts;                     // that share vertices and are drawn one by one
};

// Vertices of no triangle are left out.
CompactMesh compact(const PlainMesh& mesh);

}  // namespace vitrine
