#include "stages/view/probes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/process.h"
#include "core/math/quantile.h"
#include "core/scene/activation.h"
#include "core/trace/tracer.h"

namespace vitrine {

namespace {

constexpr float kPolished = 0.3f;  // k_s of what is, as in ShapeOptions
constexpr double kAround = 0.05;   // quantile of the polished surfels: their extent, without strays
constexpr float kBeyond = 1.02f;   // of the way out of the extent: what lies there is not the thing itself
constexpr float kShows = 0.5f;     // coverage of a ray that shows something
constexpr float kFirstHit = 0.5f;

struct Stand {
  Vec3d centre{};
  Bounds3 extent;                // of the thing around it; empty: nothing
  const Shape* shape = nullptr;  // that it is, where it is known
};

std::vector<Stand> stands(const TrainedScene& scene, const PageSurfels& surfels, const Vec3d& middle) {
  std::vector<Stand> out;
  if (const ShapeSet* set = scene.image.shape.set.get())
    for (const ShapeSet::Entry& e : set->entries) {
      if (e.role == ShapeRole::Sheet || e.parent >= 0 || out.size() == kMostProbes) continue;
      const Bounds3 b = bounds(e.shape);
      out.push_back({0.5 * (b.low + b.high), b, &e.shape});
    }
  if (!out.empty()) return out;
  std::array<std::vector<float>, 3> places;
  for (size_t i = 0; i < surfels.solid; ++i) {
    if (!(sigmoid(*surfels.layer.at(Attribute::SpecularWeight, i)) > kPolished)) continue;
    for (size_t c = 0; c < 3; ++c) places[c].push_back(surfels.layer.at(Attribute::Mean, i)[c]);
  }
  if (places[0].empty()) return {{.centre = middle, .extent = {}}};
  Bounds3 b;
  Vec3d low, high;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<float> values = places[c];
    low[c] = double(quantile_of(values, kAround));
    values = places[c];
    high[c] = double(quantile_of(values, 1 - kAround));
  }
  b.extend(low), b.extend(high);
  return {{.centre = 0.5 * (low + high), .extent = b}};
}

// Where a ray from the middle is outside of the thing around it: met from outside, that is where it begins.
float way_out(const Stand& stand, const Vec3f& direction, float near) {
  if (stand.shape != nullptr) {
    const double far = 2 * length(stand.extent.high - stand.extent.low);
    const Vec3d d = cast<double>(direction);
    if (const auto hit = intersect(*stand.shape, {stand.centre + far * d, -d})) return static_cast<float>(far - hit->t) + near;
  }
  double out = 0;
  const Vec3d half = 0.5 * (stand.extent.high - stand.extent.low);
  if (!(half.x >= 0)) return 0;
  out = 1e30;
  for (size_t c = 0; c < 3; ++c) out = std::min(out, half[c] / std::max(double(std::abs(direction[c])), 1e-9));
  return kBeyond * static_cast<float>(out);
}

SplatLayer only(const SplatLayer& layer, size_t count) {
  SplatLayer out = layer;
  out.resize(count);
  return out;
}

}  // namespace

Vec3f octahedral_direction(int x, int y, int side) {
  float px = 2 * (float(x) + 0.5f) / float(side) - 1, py = 2 * (float(y) + 0.5f) / float(side) - 1;
  const float z = 1 - std::abs(px) - std::abs(py);
  if (z < 0) {
    const float qx = (1 - std::abs(py)) * (px < 0 ? -1.f : 1.f), qy = (1 - std::abs(px)) * (py < 0 ? -1.f : 1.f);
    px = qx, py = qy;
  }
  return normalized(Vec3f{px, py, z});
}

std::vector<Probe> probes(const TrainedScene& scene, const PageSurfels& surfels, const Vec3d& middle) {
  constexpr size_t n = size_t(kProbeSide) * size_t(kProbeSide);
  std::vector<Vec3f> directions(n);
  for (size_t i = 0; i < n; ++i) directions[i] = octahedral_direction(int(i) % kProbeSide, int(i) / kProbeSide, kProbeSide);
  const SplatLayer solid = only(surfels.layer, surfels.solid);
  const auto in_room = make_tracer();
  in_room->build(solid);
  std::vector<Probe> out;
  for (const Stand& stand : stands(scene, surfels, middle)) {
    throw_if_interrupted();
    Probe p{.centre = stand.centre, .surfel = std::vector<uint32_t>(n, kNoSurfel), .depth = std::vector<float>(n, 0.f)};
    const std::vector<Vec3f> origins(n, cast<float>(stand.centre));
    std::vector<float> near(n);
    for (size_t i = 0; i < n; ++i) near[i] = way_out(stand, directions[i], scene.image.reflection.near);
    RayValues values;
    HitLists hits;
    in_room->forward({.origins = origins, .directions = directions, .near = near},
                     {.sh_degree = 0, .first_hit_weight = kFirstHit}, values, &hits);
    for (size_t i = 0; i < n; ++i) {
      if (!(1 - values.transmittance[i] > kShows)) continue;
      p.depth[i] = values.first_hit[i];
      float transmittance = 1, most = 0;
      for (const TraceHit& h : hits.of(i)) {
        if (const float w = h.alpha * transmittance; w > most) most = w, p.surfel[i] = h.surfel;
        transmittance *= 1 - h.alpha;
      }
    }
    out.push_back(std::move(p));
  }
  return out;
}

void add_probes(std::span<const Probe> probes, PageBlocks& blocks) {
  std::vector<float> depth;
  std::vector<uint32_t> surfel;
  for (const Probe& p : probes) {
    surfel.insert(surfel.end(), p.surfel.begin(), p.surfel.end());
    depth.insert(depth.end(), p.depth.begin(), p.depth.end());
  }
  blocks.indices("probe_surfel", surfel, 1);
  blocks.halves("probe_depth", depth, 1);
}

}  // namespace vitrine
