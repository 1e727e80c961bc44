#include "stages/export/bake/surface_material.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/math/rigid.h"

namespace vitrine {

namespace {

constexpr float kLeastWeight = 0.05f;  // with less, the ray only meets the tail of a Gaussian
constexpr size_t kBatch = 1 << 18;     // rays per batch: limits the memory of the hit lists

std::vector<Vec3f> disk_normals_of(const SplatLayer& layer) {
  std::vector<Vec3f> out(layer.size());
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* q = layer.at(Attribute::Rotation, i);
    out[i] = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})).c2;
  }
  return out;
}

}  // namespace

double mean_edge_length(const TriMesh& mesh) {
  double sum = 0;
  for (const auto& v : mesh.faces)
    for (size_t k = 0; k < 3; ++k) sum += double(length(mesh.positions[v[(k + 1) % 3]] - mesh.positions[v[k]]));
  return mesh.faces.empty() ? 0 : sum / double(3 * mesh.faces.size());
}

SurfaceSampler::Surfels::Surfels(const MaterialSource& from)
    : source(from), disk_normals(disk_normals_of(*from.surfels)), tracer(make_tracer()) {
  VITRINE_CHECK(from.materials.size() == from.surfels->size(), "one material per surfel");
  tracer->build(*from.surfels);
}

SurfaceSampler::SurfaceSampler(const MaterialSource& surface) : surface_(surface) {}

SurfaceSampler::SurfaceSampler(const MaterialSource& surface, const MaterialSource& behind, uint32_t first_behind)
    : surface_(surface), behind_(std::in_place, behind), first_behind_(first_behind) {}

std::vector<SurfaceSample> SurfaceSampler::samples(std::span<const Vec3f> points, std::span<const Vec3f> normals, float reach,
                                                   std::span<const uint8_t> behind) const {
  VITRINE_CHECK(points.size() == normals.size() && (behind.empty() || behind.size() == points.size()), "one normal per point");
  std::vector<SurfaceSample> out(points.size());
  std::array<std::vector<uint32_t>, 2> which;
  for (uint32_t i = 0; i < points.size(); ++i) which[behind_ && !behind.empty() && behind[i] ? 1 : 0].push_back(i);
  surface_.sample(which[0], points, normals, reach, out);
  if (behind_) behind_->sample(which[1], points, normals, reach, out);
  return out;
}

void SurfaceSampler::Surfels::sample(std::span<const uint32_t> which, std::span<const Vec3f> points,
                                     std::span<const Vec3f> normals, float reach, std::vector<SurfaceSample>& out) const {
  const TraceDesc desc{.sh_degree = source.surfels->sh_degree()};

  std::vector<Vec3f> origins, directions;
  RayValues values;
  HitLists hits;
  for (size_t begin = 0; begin < which.size(); begin += kBatch) {
    const size_t n = std::min(kBatch, which.size() - begin);
    origins.resize(n), directions.resize(n);
    for (size_t i = 0; i < n; ++i) {
      const uint32_t at = which[begin + i];
      origins[i] = points[at] + reach * normals[at];
      directions[i] = -normals[at];
    }
    const std::vector<float> far(n, 2 * reach);
    tracer->forward({.origins = origins, .directions = directions, .far = far}, desc, values, &hits);
    for (size_t i = 0; i < n; ++i) {
      SurfaceSample& s = out[which[begin + i]];
      SurfelMaterial sum{.roughness = 0};
      float through = 1, weight = 0;
      for (const TraceHit& h : hits.of(i)) {
        const float w = h.alpha * through;
        through *= 1 - h.alpha;
        weight += w;
        const SurfelMaterial& m = source.materials[h.surfel];
        sum.color += w * (h.surfel < source.with_albedo ? m.color : h.color);
        sum.f0 += w * m.f0;
        sum.roughness += w * m.roughness;
        sum.transmission += w * m.transmission;
        sum.marks += w * m.marks;
        if (!source.confidence.empty()) s.confidence += w * source.confidence[h.surfel];
        const Vec3f& disk = disk_normals[h.surfel];
        s.normal += (dot(disk, directions[i]) > 0 ? -w : w) * disk;
      }
      if (!(weight > kLeastWeight)) {
        s.normal = {};
        s.confidence = 0;
        continue;
      }
      s.weight = weight;
      s.confidence /= weight;
      s.material = {sum.color / weight, sum.f0 / weight, sum.roughness / weight, sum.transmission / weight, sum.marks / weight};
      const float l = length(s.normal);
      s.normal = l > 0.1f * weight ? s.normal / l : Vec3f{};
    }
  }
}

std::vector<SurfaceSample> sample_vertices(const SurfaceSampler& sampler, const TriMesh& mesh, float reach) {
  VITRINE_CHECK(mesh.normals.size() == mesh.positions.size(), "the mesh needs vertex normals");
  std::vector<uint8_t> behind(mesh.positions.size());
  for (uint32_t v = 0; v < behind.size(); ++v) behind[v] = sampler.is_behind(v);
  std::vector<SurfaceSample> samples = sampler.samples(mesh.positions, mesh.normals, reach, behind);
  constexpr int kRings = 64;
  for (int ring = 0; ring < kRings; ++ring) {
    std::vector<SurfaceSample> sum(samples.size());
    std::vector<int> count(samples.size(), 0);
    for (const auto& v : mesh.faces)
      for (size_t k = 0; k < 3; ++k)
        for (uint32_t from : {v[(k + 1) % 3], v[(k + 2) % 3]}) {
          if (samples[v[k]].weight > 0 || !(samples[from].weight > 0)) continue;
          const SurfelMaterial& m = samples[from].material;
          SurfelMaterial& s = sum[v[k]].material;
          s.color += m.color;
          s.f0 += m.f0;
          s.roughness += m.roughness;
          s.transmission += m.transmission;
          s.marks += m.marks;
          sum[v[k]].confidence += samples[from].confidence;
          ++count[v[k]];
        }
    bool changed = false;
    for (size_t i = 0; i < samples.size(); ++i) {
      if (count[i] == 0) continue;
      const float n = float(count[i]);
      const SurfelMaterial& s = sum[i].material;  // roughness was initialised to 1
      samples[i].material = {s.color / n, s.f0 / n, (s.roughness - 1) / n, s.transmission / n, s.marks / n};
      samples[i].confidence = sum[i].confidence / n;
      samples[i].weight = kLeastWeight;
      changed = true;
    }
    if (!changed) break;
  }
  for (size_t i = 0; i < samples.size(); ++i)
    if (!(samples[i].weight > 0)) {
      samples[i].material.color = mesh.colors.empty() ? Vec3f{0.5f, 0.5f, 0.5f} : mesh.colors[i];
      samples[i].material.f0 = {0.04f, 0.04f, 0.04f};
    }
  return samples;
}

}  // namespace vitrine
