#include "stages/optimize/initialise.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/rng.h"
#include "core/math/color.h"
#include "core/scene/activation.h"
#include "core/stereo/plane_sweep.h"
#include "stages/optimize/neighbours.h"

namespace vitrine {

namespace {

enum : uint64_t { kThinStream = 0x1901, kPixelStream = 0x1902 };

// Of the cap, so that growth has room to put surfels where the picture needs them.
constexpr double kInitialShare = 0.7;
// A ray farther than this part of the picture's diagonal from every sparse point has no depth to borrow.
constexpr double kBorrowReach = 0.12;
constexpr double kFarPercentile = 0.98;
constexpr double kOneSurface = 1.12;  // ratio of depths up to which neighbouring points are taken for one surface
constexpr double kNearShare = 0.6;    // of the nearest sparse point: where the sweep of depths begins
// Without a single sparse point the depths lie within this factor of the cameras' radius, which is 1 in the scene frame.
constexpr double kBlindDepthFactor = 4;
constexpr float kLargestSpacing = 10.f;  // in medians: isolated points would become huge

struct Seed {
  Vec3f position, normal, linear;
  float spacing_limit;  // no larger than its share of the picture
};

// A rotation whose third column is `normal`.
Quatf facing(const Vec3f& normal) {
  const Vec3d n = normalized(cast<double>(normal));
  const Vec3d helper = std::abs(n.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
  const Vec3d u = normalized(cross(helper, n));
  const Quatd q = quaternion(Mat3d{u, cross(n, u), n});
  return {float(q.w), float(q.x), float(q.y), float(q.z)};
}

// SfM points, at most `limit` of them, drawn without order.
void add_sparse_points(const ViewSet& set, size_t limit, uint64_t seed, std::vector<Seed>& seeds) {
  std::vector<uint32_t> order(set.points.size());
  std::iota(order.begin(), order.end(), 0u);
  if (order.size() > limit) {
    Rng rng(seed, kThinStream);
    for (size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[rng.below(static_cast<uint32_t>(i + 1))]);
    order.resize(limit);
    std::sort(order.begin(), order.end());
  }
  for (uint32_t index : order) {
    const ScenePoint& point = set.points[index];
    Vec3d towards{};
    for (uint32_t view : point.views) {
      const Vec3d direction = set.views[view].centre_in_world() - point.position;
      if (const double distance = length(direction); distance > 0) towards += direction / distance;
    }
    if (!(length(towards) > 0)) towards = {0, 0, 1};
    seeds.push_back({cast<float>(point.position), cast<float>(normalized(towards)), point.linear_rgb, 1e30f});
  }
}

struct ProjectedPoint {
  double x, y, z;
};

// The sparse points that a view saw, in its picture.
std::vector<std::vector<ProjectedPoint>> projected_points(const ViewSet& set, const Capture& capture) {
  std::vector<std::vector<ProjectedPoint>> seen(set.views.size());
  for (const ScenePoint& point : set.points)
    for (uint32_t v : point.views) {
      const View& view = capture.photos[v].levels[0].view;
      const Vec3d p = view.cam_from_world * point.position;
      if (p.z <= 0) continue;
      const Intrinsics& k = view.intrinsics;
      seen[v].push_back({k.fx * p.x / p.z + k.cx, k.fy * p.y / p.z + k.cy, p.z});
    }
  return seen;
}

// Depth at (x, y) from the three nearest known points: empty where they lie on different surfaces (a surfel at their mean would
// float between them), `far_z` when none is within `reach`.
std::optional<double> borrowed_depth(const std::vector<ProjectedPoint>& points, double x, double y, double reach, double far_z) {
  struct Near {
    double squared, z;
  };
  std::array<Near, 3> best;
  best.fill({1e300, 0});
  for (const ProjectedPoint& p : points) {
    const double squared = (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y);
    if (squared >= best[2].squared) continue;
    best[2] = {squared, p.z};
    if (best[2].squared < best[1].squared) std::swap(best[1], best[2]);
    if (best[1].squared < best[0].squared) std::swap(best[0], best[1]);
  }
  if (best[0].squared > reach * reach) return far_z;
  double weights = 0, inverse = 0, nearest = 1e300, farthest = 0;
  for (const Near& n : best) {
    if (n.z <= 0) continue;
    const double weight = 1 / (n.squared + 1);
    weights += weight;
    inverse += weight / n.z;
    nearest = std::min(nearest, n.z);
    farthest = std::max(farthest, n.z);
  }
  if (farthest > kOneSurface * nearest) return std::nullopt;
  return weights / inverse;
}

// What a ray's surfel starts from: the colour of its pixel, and a depth.
Seed pixel_seed(const PhotoLevel& photo, double x, double y, double z) {
  const Intrinsics& k = photo.view.intrinsics;
  const Rigid world_from_cam = inverse(photo.view.cam_from_world);
  const Vec3d position = world_from_cam * (z * k.ray(x, y));
  const size_t pixels = photo.srgb.size() / 3;
  const size_t pixel = std::min<size_t>(static_cast<size_t>(y), size_t(k.height) - 1) * size_t(k.width) +
                       std::min<size_t>(static_cast<size_t>(x), size_t(k.width) - 1);
  Seed seed;
  seed.position = cast<float>(position);
  seed.normal = cast<float>(normalized(world_from_cam.translation - position));
  for (size_t c = 0; c < 3; ++c)
    seed.linear[c] = linear_from_srgb(float(photo.srgb[c * pixels + pixel]) / 65535.f) / float(photo.view.gain[c]);
  return seed;
}

// Quarter size where that leaves a picture: its patches of 28 pixels of the photo are surer than finer ones, and quicker.
size_t level_for_sweep(const Capture& capture) {
  constexpr int kSmallestSide = 120;
  size_t level = kLevels - 1;
  const auto side = [&](size_t l) {
    const Intrinsics& k = capture.photos[capture.train.front()].levels[l].view.intrinsics;
    return std::max(k.width, k.height);
  };
  while (level > 0 && side(level) < kSmallestSide) --level;
  return level;
}

// Luma of Rec.709 on encoded values: what the eye, and a correlation, sees of an edge. Held-out photos take no part.
std::vector<SweepPhoto> sweep_photos(const Capture& capture, size_t level) {
  std::vector<SweepPhoto> photos(capture.photos.size());
  for (size_t p = 0; p < photos.size(); ++p) photos[p].view = capture.photos[p].levels[level].view;
  parallel_for(capture.train.size(), 1, [&](size_t t) {
    const PhotoLevel& photo = capture.photos[capture.train[t]].levels[level];
    const Intrinsics& k = photo.view.intrinsics;
    ImageF grey(k.width, k.height, 1);
    const size_t pixels = grey.pixel_count();
    for (size_t i = 0; i < pixels; ++i)
      grey.data()[i] = (0.2126f * float(photo.srgb[i]) + 0.7152f * float(photo.srgb[pixels + i]) +
                        0.0722f * float(photo.srgb[2 * pixels + i])) /
                       65535.f;
    photos[capture.train[t]].grey = std::move(grey);
  });
  return photos;
}

// `count` rays of the training photos: surfels at the depth that a plane sweep finds, else at the depth of known points
// nearby, else behind all of them. A photo without sparse points waits for the surfels of the others, unless none has any.
void add_frustum_points(const OptimizeConfig& config, const Capture& capture, size_t count, std::vector<Seed>& seeds) {
  const auto sparse = projected_points(capture.view_set, capture);
  const size_t views = capture.train.size();
  const bool blind = std::all_of(capture.train.begin(), capture.train.end(), [&](uint32_t v) { return sparse[v].empty(); });
  const size_t sweep_level = level_for_sweep(capture);
  const PlaneSweep sweep(sweep_photos(capture, sweep_level));
  std::vector<std::vector<Seed>> found(views);
  parallel_for(views, 1, [&](size_t t) {
    const uint32_t v = capture.train[t];
    if (sparse[v].empty() && !blind) return;
    double near_z = 1 / kBlindDepthFactor, far_z = kBlindDepthFactor;
    std::vector<ProjectedPoint> known = sparse[v];
    if (!blind) {
      std::vector<double> depths;
      for (const ProjectedPoint& p : known) depths.push_back(p.z);
      std::sort(depths.begin(), depths.end());
      near_z = kNearShare * depths.front();
      far_z = config.initial.far_factor * depths[static_cast<size_t>(kFarPercentile * double(depths.size() - 1))];
    }
    const PhotoLevel& photo = capture.photos[v].levels[0];
    const Intrinsics& k = photo.view.intrinsics;
    const Intrinsics& swept_k = capture.photos[v].levels[sweep_level].view.intrinsics;
    const size_t share = (t + 1) * count / views - t * count / views;
    const double area = double(k.width) * k.height, reach = kBorrowReach * std::hypot(k.width, k.height);
    const double spacing_px = std::sqrt(area / double(std::max<size_t>(share, 1)));
    std::vector<Vec2d> unknown;
    for (size_t s = 0; s < share; ++s) {
      Rng rng(static_cast<uint64_t>(config.seed), mix64(kPixelStream, mix64(v, s)));
      const double x = rng.uniform_double() * k.width, y = rng.uniform_double() * k.height;
      const auto swept = sweep.at(v, x * swept_k.width / k.width, y * swept_k.height / k.height, near_z, far_z);
      if (!swept) {
        unknown.push_back({x, y});
        continue;
      }
      found[t].push_back(pixel_seed(photo, x, y, swept->zdepth));
      found[t].back().normal = cast<float>(swept->normal_in_world);
      found[t].back().spacing_limit = static_cast<float>(spacing_px * swept->zdepth / k.fx);
      known.push_back({x, y, swept->zdepth});
    }
    for (const Vec2d& p : unknown) {
      const auto z = borrowed_depth(known, p.x, p.y, reach, far_z);
      if (!z) continue;
      found[t].push_back(pixel_seed(photo, p.x, p.y, *z));
      found[t].back().spacing_limit = static_cast<float>(spacing_px * *z / k.fx);
    }
  });
  for (const auto& of_view : found) seeds.insert(seeds.end(), of_view.begin(), of_view.end());
}

}  // namespace

SplatLayer initial_layer(const OptimizeConfig& config, const Capture& capture, size_t max_surfels) {
  const size_t limit = std::max<size_t>(1, static_cast<size_t>(kInitialShare * double(max_surfels)));
  std::vector<Seed> seeds;
  add_sparse_points(capture.view_set, limit, static_cast<uint64_t>(config.seed), seeds);
  add_frustum_points(config, capture, std::min<size_t>(size_t(config.initial.frustum_points), limit - seeds.size()), seeds);
  if (seeds.empty())
    throw Error(ErrorKind::Input, "there is nothing to start from",
                {.why = "the sfm stage found no sparse point in any training photo, and frustum_points is 0",
                 .hint = "--set optimize.initial.frustum_points=20000, or photos with more overlap and texture",
                 .code = "NO_SPARSE_POINTS"});

  std::vector<Vec3f> positions;
  for (const Seed& seed : seeds) positions.push_back(seed.position);
  std::vector<float> spacing = neighbour_spacing(positions), sorted = spacing;
  std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
  const float median = std::max(sorted[sorted.size() / 2], 1e-6f);

  SplatLayer layer(LayerKind::Diffuse, config.sh_degree, seeds.size());
  for (size_t i = 0; i < seeds.size(); ++i) {
    const Seed& seed = seeds[i];
    const Quatf q = facing(seed.normal);
    float* rotation = layer.at(Attribute::Rotation, i);
    rotation[0] = q.w, rotation[1] = q.x, rotation[2] = q.y, rotation[3] = q.z;
    const float nearest = spacing[i] > 0 ? spacing[i] : median;
    const float scale =
        float(config.initial.scale) * std::max(std::min({nearest, seed.spacing_limit, kLargestSpacing * median}), 1e-3f * median);
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = std::log(scale);
    for (size_t c = 0; c < 3; ++c) {
      layer.at(Attribute::Mean, i)[c] = seed.position[c];
      layer.at(Attribute::ShDc, i)[c] = (seed.linear[c] - 0.5f) / kShDc;
    }
    *layer.at(Attribute::Opacity, i) = logit(static_cast<float>(config.initial.opacity));
    for (Attribute a : {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission})
      std::fill_n(layer.at(a, i), layer.width(a), raw_value(row(a).activation, row(a).initial));
  }
  return layer;
}

}  // namespace vitrine
