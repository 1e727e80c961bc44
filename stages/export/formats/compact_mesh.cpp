#include "stages/export/formats/compact_mesh.h"

#include <meshoptimizer.h>
#include <algorithm>

namespace vitrine {

namespace {

constexpr float kCacheForOverdraw = 1.05f;  // allowed worsening of the vertex cache for less overdraw
constexpr uint32_t kUnused = ~0u;

std::vector<uint32_t> drawing_order(const Triangles& triangles, std::span<const Vec3f> positions) {
  static_assert(sizeof(Triangles::value_type) == 12 && sizeof(Vec3f) == 12);
  std::vector<uint32_t> cached(3 * triangles.size()), order(cached.size());
  meshopt_optimizeVertexCache(cached.data(), triangles.data()->data(), cached.size(), positions.size());
  meshopt_optimizeOverdraw(order.data(), cached.data(), order.size(), &positions.data()->x, positions.size(), sizeof(Vec3f),
                           kCacheForOverdraw);
  return order;
}

}  // namespace

CompactMesh compact(const PlainMesh& mesh) {
  const size_t before = mesh.positions.size();
  CompactMesh out;
  std::vector<uint32_t> all;
  for (const Triangles& part : mesh.parts) {
    if (part.empty()) continue;
    const std::vector<uint32_t> order = drawing_order(part, mesh.positions);
    all.insert(all.end(), order.begin(), order.end());
  }
  std::vector<uint32_t> place(before, kUnused), from;
  from.resize(all.empty() ? 0 : meshopt_optimizeVertexFetchRemap(place.data(), all.data(), all.size(), before));
  for (uint32_t v = 0; v < before; ++v)
    if (place[v] != kUnused) from[place[v]] = v;
  out.source = from;
  size_t next = 0;
  for (const Triangles& part : mesh.parts) {
    Triangles& to = out.parts.emplace_back(part.size());
    for (auto& corners : to)
      for (uint32_t& corner : corners) corner = place[all[next++]];
  }

  Vec3f low{}, high{};
  for (size_t i = 0; i < from.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const float v = mesh.positions[from[i]][c];
      low[c] = i == 0 ? v : std::min(low[c], v), high[c] = i == 0 ? v : std::max(high[c], v);
    }
  out.origin = low;
  const float side = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  if (side > 0) out.side = side;
  for (const uint32_t v : from) {
    for (size_t c = 0; c < 3; ++c) {
      out.positions.push_back(uint16_t(meshopt_quantizeUnorm((mesh.positions[v][c] - low[c]) / out.side, 16)));
      out.normals.push_back(int16_t(meshopt_quantizeSnorm(mesh.normals[v][c], 16)));
      out.tangents.push_back(int8_t(meshopt_quantizeSnorm(mesh.tangents[v][c], 8)));
    }
    out.tangents.push_back(127);
    for (const float v01 : {mesh.uv[v].x, mesh.uv[v].y}) out.uv.push_back(uint16_t(meshopt_quantizeUnorm(v01, 16)));
  }
  return out;
}

}  // namespace vitrine
