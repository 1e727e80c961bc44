// Mesh compaction for GPUs: triangles ordered for the vertex cache and low overdraw, vertices in order of first use (both by
// meshoptimizer), and attributes as short integers (KHR_mesh_quantization of glTF):
//   position  16 bits per coordinate of the bounding cube: error at most 8e-6 of its side
//   normal    16 bits, tangent 8 bits, of [-1, 1]
//   uv        16 bits of [0, 1]: error at most 0.02 texels of a texture of 2048
// Deterministic.
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
  std::vector<int8_t> tangents;     // [n,4] in 127ths; the fourth is the handedness of the bitangent
  std::vector<uint16_t> uv;         // [n,2] in 65535ths
  std::vector<uint32_t> source;     // [n] vertex of the given mesh
  std::vector<Triangles> parts;     // the given parts, indexing vertices of this mesh
  Vec3f origin{};
  float side = 1;

  size_t vertex_count() const { return positions.size() / 3; }
};

struct PlainMesh {
  std::span<const Vec3f> positions, normals, tangents;  // [vertices] normals and tangents unit, bitangent = normal x tangent
  std::span<const Vec2f> uv;                            // [vertices] within [0, 1]
  std::span<const Triangles> parts;                     // share vertices and are rendered separately
};

// Unreferenced vertices are removed.
CompactMesh compact(const PlainMesh& mesh);

}  // namespace vitrine
