#include "stages/view/page_surfels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/quantile.h"
#include "core/render/model/opened_scene.h"
#include "core/scene/light/environment.h"

namespace vitrine {

namespace {

constexpr float kSpecular = 0.3f;         // minimum k_s or f0 of a specular surfel, as in ShapeOptions
constexpr double kExtentQuantile = 0.05;  // quantile of the positions of specular surfels: robust extent
constexpr float kLift = 4;                // in grains of the mesh: ray offset from a known shape, clear of its mesh
constexpr int kMostBumps = 4;
constexpr float kFree = 0.1f;     // in grains
constexpr float kBeyond = 1.02f;  // relative to the boundary of the extent: outside the object

struct ProbeSite {
  Vec3d centre{};
  Bounds3 extent;                // of the object; empty: none
  const Shape* shape = nullptr;  // known shape of the object, or nullptr
};

std::vector<ProbeSite> probe_sites(const RelitScene& scene, const Vec3d& middle) {
  std::vector<ProbeSite> out;
  if (const ShapeSet* set = scene.trained.image.shape.set.get())
    for (const ShapeSet::Entry& e : set->entries) {
      if (is_glass(e.role) || e.parent >= 0 || out.size() == kMostProbes) continue;
      const Bounds3 b = bounds(e.shape);
      out.push_back({0.5 * (b.low + b.high), b, &e.shape});
    }
  if (!out.empty()) return out;
  std::array<std::vector<float>, 3> places;
  const SplatLayer& surfels = scene.trained.surfels.diffuse;
  for (size_t i = 0; i < surfels.size(); ++i) {
    const RelitMaterial m = scene.material(i);
    if (is_glass(surfels, i) || std::max(m.specular, (m.f0.x + m.f0.y + m.f0.z) / 3) <= kSpecular) continue;
    for (size_t c = 0; c < 3; ++c) places[c].push_back(surfels.at(Attribute::Mean, i)[c]);
  }
  if (places[0].empty()) return {{.centre = middle, .extent = {}}};
  Bounds3 b;
  Vec3d low, high;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<float> values = places[c];
    low[c] = double(quantile_of(values, kExtentQuantile));
    values = places[c];
    high[c] = double(quantile_of(values, 1 - kExtentQuantile));
  }
  b.extend(low), b.extend(high);
  return {{.centre = 0.5 * (low + high), .extent = b}};
}

// Distance from the centre along a ray at which it has left the object; for a known shape its outermost hit.
float exit_distance(const ProbeSite& site, const Vec3f& direction, float near) {
  if (site.shape != nullptr) {
    const double far = 2 * length(site.extent.high - site.extent.low);
    const Vec3d d = cast<double>(direction);
    if (const auto hit = intersect(*site.shape, {site.centre + far * d, -d})) return static_cast<float>(far - hit->t) + near;
  }
  double out = 0;
  const Vec3d half = 0.5 * (site.extent.high - site.extent.low);
  if (!(half.x >= 0)) return 0;
  out = 1e30;
  for (size_t c = 0; c < 3; ++c) out = std::min(out, half[c] / std::max(double(std::abs(direction[c])), 1e-9));
  return kBeyond * static_cast<float>(out);
}

}  // namespace

float clear_of_surface(const RelitScene& scene, const LightTransfer& transfer) {
  return std::max(scene.trained.image.reflection.near, kLift * transfer.surface().grain());
}

std::vector<LightProbe> probes(const RelitScene& scene, const LightTransfer& transfer, const Vec3d& middle) {
  constexpr size_t n = size_t(kProbeSide) * size_t(kProbeSide);
  const float lift = clear_of_surface(scene, transfer);
  std::vector<LightProbe> out;
  for (const ProbeSite& site : probe_sites(scene, middle)) {
    LightProbe p{
        .centre = site.centre, .sent = std::vector<Transfer>(n), .open = std::vector<float>(n), .depth = std::vector<float>(n)};
    parallel_for(n, size_t(kProbeSide), [&](size_t i) {
      throw_if_interrupted();
      const Vec3f d = octahedral_direction(2 * (float(i % kProbeSide) + 0.5f) / kProbeSide - 1,
                                           2 * (float(i / kProbeSide) + 0.5f) / kProbeSide - 1);
      const Vec3f centre = cast<float>(site.centre);
      float start = exit_distance(site, d, lift);
      // Skips bumps of the object's own mesh.
      for (int bumps = 0; bumps < kMostBumps; ++bumps) {
        const auto hit = transfer.surface().first_hit(centre + start * d, d);
        if (!hit || !hit->from_inside) break;
        start += hit->t + kFree * transfer.surface().grain();
      }
      const LightTransfer::Arrival a = transfer.arriving(centre + start * d, d);
      p.sent[i] = a.from_scene, p.open[i] = a.from_outside;
      p.depth[i] = a.distance > 0 ? a.distance + start : 0.f;
    });
    out.push_back(std::move(p));
  }
  return out;
}

void add_probes(std::span<const LightProbe> probes, PageBlocks& blocks) {
  std::vector<Transfer> sent;
  std::vector<float> way;
  for (const LightProbe& p : probes) {
    sent.insert(sent.end(), p.sent.begin(), p.sent.end());
    for (size_t i = 0; i < p.open.size(); ++i) way.insert(way.end(), {p.open[i], p.depth[i]});
  }
  add_transfers("probe", sent, kTransferDegree, blocks);
  blocks.halves("probe_way", way, 2);
}

}  // namespace vitrine
