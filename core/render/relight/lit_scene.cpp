#include "core/render/relight/lit_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/render/model/kernels/mirror.h"
#include "core/render/relight/sample_points.h"

namespace vitrine {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr size_t kGrain = 256;  // vertices
constexpr float kLift = 1;      // in grains: offset of rays above the mesh
constexpr uint64_t kDirectStream = 0x11, kGatherStream = 0x12, kFluenceStream = 0x13;
constexpr int kSmoothings = 2;

// Hit of a gather ray, stored for all bounces. After panes: the solid surface with the largest share.
struct Gathered {
  SurfacePlace place;
  float share = 0;
};

}  // namespace

LitScene::LitScene(const SceneSurface& surface, const Lighting& lighting, const LitSceneDesc& desc)
    : surface_(&surface), lighting_(&lighting), desc_(desc) {
  std::vector<Vec3f> direct = direct_irradiance();
  for (int i = 0; i < kSmoothings; ++i) smooth(direct);
  bounce(direct);
}

std::vector<Vec3f> LitScene::direct_irradiance() const {
  const TriMesh& mesh = surface_->mesh();
  std::vector<Vec3f> out(mesh.positions.size());
  const auto n = static_cast<uint32_t>(desc_.light_samples);
  const Environment& environment = lighting_->environment;
  parallel_chunks(out.size(), kGrain, [&](size_t, size_t first, size_t last) {
    throw_if_interrupted();
    for (size_t v = first; v < last; ++v) {
      const Vec3f& normal = mesh.normals[v];
      const Vec3f origin = mesh.positions[v] + kLift * surface_->grain() * normal;
      const SamplePoints points(desc_.seed, mix64(kDirectStream, v));
      Vec3f sum{};
      if (!environment.black())
        for (uint32_t i = 0; i < n; ++i) {
          const Environment::Sample s = environment.sample(points.point(0, i));
          const float cosine = dot(normal, s.direction);
          if (!(cosine > 0)) continue;
          sum += (cosine / (s.pdf * float(n)) * surface_->visibility(origin, s.direction)) * s.radiance;
        }
      for (size_t lamp = 0; lamp < lighting_->lamps(); ++lamp) {
        const uint32_t samples = lamp < lighting_->sharp_lamps() ? 1 : n;
        for (uint32_t i = 0; i < samples; ++i) {
          const LampSample s = lighting_->sample_lamp(lamp, origin, points.point(1, i));
          const float cosine = dot(normal, s.direction);
          if (!(s.pdf > 0 && cosine > 0)) continue;
          sum += (cosine / (s.pdf * float(samples)) * surface_->visibility(origin, s.direction, s.distance)) * s.radiance;
        }
      }
      out[v] = sum;
    }
  });
  return out;
}

void LitScene::bounce(const std::vector<Vec3f>& direct) {
  const TriMesh& mesh = surface_->mesh();
  const auto rays = static_cast<uint32_t>(desc_.gather_rays);
  const size_t n = direct.size();
  std::vector<Gathered> gathered(desc_.bounces > 1 ? n * rays : 0);
  parallel_chunks(gathered.empty() ? 0 : n, kGrain, [&](size_t, size_t first, size_t last) {
    throw_if_interrupted();
    for (size_t v = first; v < last; ++v) {
      const Vec3f& normal = mesh.normals[v];
      const Vec3f origin = mesh.positions[v] + kLift * surface_->grain() * normal;
      const SamplePoints points(desc_.seed, mix64(kGatherStream, v));
      Vec3f t0, t1;
      tangents(normal, t0, t1);
      for (uint32_t i = 0; i < rays; ++i) {
        const Vec2f u = points.point(0, i);
        const float r = std::sqrt(u.x), phi = 2 * kPi * u.y;
        const Vec3f d = (r * std::cos(phi)) * t0 + (r * std::sin(phi)) * t1 + std::sqrt(std::max(1 - u.x, 0.f)) * normal;
        Gathered& g = gathered[v * rays + i];
        surface_->follow(origin, d, [&](const SceneSurface::Meeting& m) {
          if (m.front && m.share > g.share) g = {m.place, m.share};
        });
      }
    }
  });
  radiance_.resize(n);
  irradiance_ = direct;
  for (int b = 1;; ++b) {
    surface_->subsurface().apply(irradiance_);
    for (size_t v = 0; v < n; ++v) radiance_[v] = hadamard(surface_->reflectance()[v], irradiance_[v]) / kPi;
    if (b >= desc_.bounces || gathered.empty()) break;
    std::vector<Vec3f> indirect(n);
    parallel_chunks(n, kGrain, [&](size_t, size_t first, size_t last) {
      for (size_t v = first; v < last; ++v) {
        Vec3f sum{};
        for (uint32_t i = 0; i < rays; ++i)
          if (const Gathered& g = gathered[v * rays + i]; g.share > 0) sum += g.share * surface_->at(radiance_, g.place);
        indirect[v] = (kPi / float(rays)) * sum;
      }
    });
    smooth(indirect);
    for (size_t v = 0; v < n; ++v) irradiance_[v] = direct[v] + indirect[v];
  }
}

// Averages over neighbours with similar normals: reduces Monte Carlo noise, keeps edges.
void LitScene::smooth(std::vector<Vec3f>& values) const {
  const TriMesh& mesh = surface_->mesh();
  std::vector<Vec3f> sum = values;
  std::vector<float> weight(values.size(), 1.f);
  for (const auto& f : mesh.faces)
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = f[i], b = f[(i + 1) % 3];
      float w = std::max(dot(mesh.normals[a], mesh.normals[b]), 0.f);
      w *= w, w *= w, w *= 0.5f * w;  // each edge is visited from both of its faces
      sum[a] += w * values[b], sum[b] += w * values[a];
      weight[a] += w, weight[b] += w;
    }
  for (size_t v = 0; v < values.size(); ++v) values[v] = sum[v] / weight[v];
}

LitScene::Arrival LitScene::arriving(const Vec3f& origin, const Vec3f& direction) const {
  Arrival a;
  a.from_outside = surface_->follow(
      origin, direction, [&](const SceneSurface::Meeting& m) { a.from_scene += m.share * surface_->at(radiance_, m.place); });
  return a;
}

template <class Take>
void LitScene::sample_arriving(const Vec3f& point, uint64_t stream, int samples, const Take& take) const {
  const SamplePoints points(desc_.seed, mix64(kFluenceStream, stream));
  const auto n = static_cast<uint32_t>(samples);
  const Environment& environment = lighting_->environment;
  for (uint32_t i = 0; i < n; ++i) {
    const float per_sample = 1 / (4 * kPi * float(n));
    if (!environment.black()) {
      const Environment::Sample s = environment.sample(points.point(0, i));
      take(s.direction, (per_sample / s.pdf * surface_->visibility(point, s.direction)) * s.radiance);
    }
    const Vec2f u = points.point(1, i);
    const float z = 1 - 2 * u.x, r = std::sqrt(std::max(1 - z * z, 0.f)), phi = 2 * kPi * u.y;
    const Vec3f direction{r * std::cos(phi), r * std::sin(phi), z};
    take(direction, (1 / float(n)) * arriving(point, direction).from_scene);
    for (size_t lamp = 0; lamp < lighting_->lamps(); ++lamp) {
      const LampSample s = lighting_->sample_lamp(lamp, point, points.point(2, i));
      if (s.pdf > 0) take(s.direction, (per_sample / s.pdf * surface_->visibility(point, s.direction, s.distance)) * s.radiance);
    }
  }
}

Vec3f LitScene::fluence(const Vec3f& point, uint64_t stream, int samples) const {
  Vec3f sum{};
  sample_arriving(point, stream, samples, [&](const Vec3f&, const Vec3f& radiance) { sum += radiance; });
  return sum;
}

// Fluence is the mean over 4 pi: E / pi is 4 times the mean of L n.l.
Vec3f LitScene::irradiance_in_the_open(const Patch& patch, const Blocked& blocked, uint64_t stream, int samples) const {
  Vec3f sum{};
  sample_arriving(patch.point, stream, samples, [&](const Vec3f& direction, const Vec3f& radiance) {
    const float cosine = dot(direction, patch.normal);
    if (cosine > 0 && radiance != Vec3f{} && !blocked(direction)) sum += (4 * cosine) * radiance;
  });
  return sum;
}

}  // namespace vitrine
