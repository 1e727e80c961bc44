#include "stages/optimize/initialise.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/kd_tree.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/vec.h"
#include "core/observe/stereo/borrowed_depth.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

enum : uint64_t { kThinStream = 0x1901, kPixelStream = 0x1902 };

// Share of the cap, which leaves room for densification.
constexpr double kInitialShare = 0.7;
// Largest distance, relative to the picture's diagonal, from a sparse point whose depth a ray may use.
constexpr double kBorrowReach = 0.12;
constexpr double kOneSurface = 1.12;     // largest ratio of depths of neighbouring points on one surface
constexpr double kUnknownDemand = 0.5;   // sampling weight of a pixel without depth: half of that of a pixel seen by one photo
constexpr float kLargestSpacing = 10.f;  // in medians: isolated points would become huge
constexpr float kInitialOpacity = 0.3f;
constexpr double kSkyShare = 0.9;  // of the background's distance

struct Seed {
  Vec3f position, normal, linear;
  float spacing_limit;  // limits the size to its share of the picture
  float distance = 0;   // from the cameras that show `linear`, mean
  bool sky = false;     // at the background distance: the size is its share of the picture, independent of its neighbours
};

// Adds at most `limit` SfM points, sampled at random.
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
    double distance = 0;
    for (uint32_t view : point.views)
      distance += length(set.views[view].centre_in_world() - point.position) / double(point.views.size());
    if (!(length(towards) > 0)) towards = {0, 0, 1};
    seeds.push_back({cast<float>(point.position), cast<float>(normalized(towards)), point.linear_rgb, 1e30f, float(distance)});
  }
}

// Initial surfel of a pixel: its colour at a given depth.
Seed pixel_seed(const PhotoLevel& photo, double x, double y, double z) {
  const Intrinsics& k = photo.view.intrinsics;
  const Rigid world_from_cam = inverse(photo.view.cam_from_world);
  const Vec3d position = world_from_cam * (z * k.ray(x, y));
  const size_t pixel = std::min<size_t>(static_cast<size_t>(y), size_t(k.height) - 1) * size_t(k.width) +
                       std::min<size_t>(static_cast<size_t>(x), size_t(k.width) - 1);
  Seed seed;
  seed.position = cast<float>(position);
  seed.normal = cast<float>(normalized(world_from_cam.translation - position));
  seed.linear = linear_at(photo, pixel);
  seed.distance = static_cast<float>(length(world_from_cam.translation - position));
  return seed;
}

// Sampling weight of a pixel: 1 / (number of photos that see the same point), so that each point gets one surfel in total.
double demand(const DepthMap& map, size_t pixel) {
  return map.reliable(pixel) ? 1.0 / (1 + map.agreeing[pixel]) : kUnknownDemand;
}

// Adds surfels for `count` pixel rays of the training photos: at the depth of dense stereo, else at the depth of nearby sparse
// points, else at the background. Photos without sparse points get none, unless no photo has any.
void add_frustum_points(const OptimizeConfig& config, const Capture& capture, const DenseDepth& dense, size_t count,
                        std::vector<Seed>& seeds) {
  if (count == 0) return;
  const size_t views = capture.train.size();
  const auto of = [&](size_t t) -> const DepthMap& { return dense.maps[capture.train[t]]; };
  std::vector<double> demanded(views + 1, 0);  // running sums of the weights
  const bool blind = std::all_of(dense.photos.begin(), dense.photos.end(), [](const StereoPhoto& p) { return p.hints.empty(); });
  for (size_t t = 0; t < views; ++t) {
    double own = 0;
    if (blind || !dense.photos[capture.train[t]].hints.empty()) {
      if (of(t).zdepth.empty()) own = kUnknownDemand;
      for (size_t i = 0; i < of(t).zdepth.size(); ++i) own += demand(of(t), i) / double(of(t).zdepth.size());
    }
    demanded[t + 1] = demanded[t] + own;
  }
  if (!(demanded.back() > 0)) return;

  std::vector<std::vector<Seed>> found(views);
  parallel_for(views, 1, [&](size_t t) {
    const auto until = [&](size_t v) { return static_cast<size_t>(double(count) * demanded[v] / demanded.back() + 0.5); };
    const size_t share = until(t + 1) - until(t);
    if (share == 0) return;
    const uint32_t v = capture.train[t];
    const DepthMap& map = of(t);
    const PhotoLevel& photo = capture.photos[v].levels[0];
    const Intrinsics &k = photo.view.intrinsics, &matched = dense.photos[v].view.intrinsics;
    const double area = double(k.width) * k.height, reach = kBorrowReach * std::hypot(k.width, k.height);
    const double width_ratio = double(matched.width) / k.width, height_ratio = double(matched.height) / k.height;
    const double mean_demand = (demanded[t + 1] - demanded[t]);
    std::vector<PixelDepth> known;  // for a photo without stereo depth
    for (const Vec3d& h : dense.photos[v].hints) known.push_back({h.x / width_ratio, h.y / height_ratio, h.z});
    const auto spacing = [&](double pixel_demand) { return std::sqrt(area * mean_demand / (double(share) * pixel_demand)); };
    Rng rng(static_cast<uint64_t>(config.seed), mix64(kPixelStream, v));
    for (size_t s = 0; s < share;) {
      const double x = rng.uniform_double() * k.width, y = rng.uniform_double() * k.height, chance = rng.uniform_double();
      if (map.zdepth.empty()) {
        ++s;
        const auto borrowed = borrowed_depth(known, x, y, reach);
        if (borrowed && borrowed->spread > kOneSurface) continue;  // a surfel between two surfaces would float
        const double z = borrowed ? borrowed->z : dense.photos[v].far_z;
        found[t].push_back(pixel_seed(photo, x, y, z));
        found[t].back().spacing_limit = static_cast<float>(spacing(kUnknownDemand) * z / k.fx);
        continue;
      }
      const int mx = std::min(int(x * width_ratio), map.width - 1), my = std::min(int(y * height_ratio), map.height - 1);
      const size_t pixel = map.index(mx, my);
      const double wanted = demand(map, pixel);
      if (chance >= wanted) continue;
      ++s;
      // Intersects the pixel's plane with the ray through (x, y).
      const Vec3d normal = cast<double>(map.normal[pixel]);
      const double facing = dot(normal, k.ray(x, y));
      const bool sky = double(map.zdepth[pixel]) > kSkyShare * dense.background;
      const double z = sky ? dense.background / length(k.ray(x, y))
                           : double(map.zdepth[pixel]) * dot(normal, matched.ray(mx + 0.5, my + 0.5)) / facing;
      if (!(facing < 0) || !(z > 0)) continue;
      found[t].push_back(pixel_seed(photo, x, y, z));
      if (!sky) found[t].back().normal = cast<float>(transposed_times(photo.view.cam_from_world.rotation, normal));
      found[t].back().spacing_limit = static_cast<float>(spacing(wanted) * z / k.fx);
      found[t].back().sky = sky;
    }
  });
  for (const auto& of_view : found) seeds.insert(seeds.end(), of_view.begin(), of_view.end());
}

}  // namespace

Quatf rotation_facing(const Vec3f& normal) {
  const Vec3d n = normalized(cast<double>(normal));
  const auto [u, v] = orthonormal_basis(n);
  const Quatd q = quaternion(Mat3d{u, v, n});
  return {float(q.w), float(q.x), float(q.y), float(q.z)};
}

SplatLayer initial_layer(const OptimizeConfig& config, const Capture& capture, const DenseDepth& dense, size_t max_surfels,
                         const std::function<bool(const Vec3d&)>& keep, const MediumCoefficients<double>* medium) {
  const size_t limit = std::max<size_t>(1, static_cast<size_t>(kInitialShare * double(max_surfels)));
  std::vector<Seed> seeds;
  add_sparse_points(capture.view_set, limit, static_cast<uint64_t>(config.seed), seeds);
  add_frustum_points(config, capture, dense, std::min<size_t>(size_t(config.initial.frustum_points), limit - seeds.size()),
                     seeds);
  if (keep) std::erase_if(seeds, [&](const Seed& seed) { return !keep(cast<double>(seed.position)); });
  for (Seed& seed : seeds)
    if (medium) seed.linear = cast<float>(without_medium(*medium, cast<double>(seed.linear), double(seed.distance)));
  if (seeds.empty())
    throw Error(ErrorKind::Input, "there is nothing to start from",
                {.why = "the sfm stage found no sparse point in any training photo, and frustum_points is 0",
                 .hint = "--set optimize.initial.frustum_points=20000, or photos with more overlap and texture",
                 .code = "NO_SPARSE_POINTS"});

  std::vector<Vec3f> positions;
  for (const Seed& seed : seeds) positions.push_back(seed.position);
  const std::vector<float> spacing = neighbour_spacing(positions);
  std::vector<float> near_by;
  for (size_t i = 0; i < seeds.size(); ++i)
    if (!seeds[i].sky) near_by.push_back(spacing[i]);
  const float median = std::max(near_by.empty() ? 0.f : upper_median(near_by), 1e-6f);

  SplatLayer layer(LayerKind::Diffuse, config.sh_degree, seeds.size());
  for (size_t i = 0; i < seeds.size(); ++i) {
    const Seed& seed = seeds[i];
    const Quatf q = rotation_facing(seed.normal);
    float* rotation = layer.at(Attribute::Rotation, i);
    rotation[0] = q.w, rotation[1] = q.x, rotation[2] = q.y, rotation[3] = q.z;
    const float nearest = spacing[i] > 0 ? spacing[i] : median;
    const float largest = seed.sky ? seed.spacing_limit : std::min(seed.spacing_limit, kLargestSpacing * median);
    const float scale = std::max(std::min(nearest, largest), 1e-3f * median);
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = std::log(scale);
    for (size_t c = 0; c < 3; ++c) {
      layer.at(Attribute::Mean, i)[c] = seed.position[c];
      layer.at(Attribute::ShDc, i)[c] = (seed.linear[c] - 0.5f) / kShDc;
    }
    *layer.at(Attribute::Opacity, i) = logit(kInitialOpacity);
    for (Attribute a : {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission})
      std::fill_n(layer.at(a, i), layer.width(a), raw_value(row(a).activation, row(a).initial));
  }
  return layer;
}

std::vector<float> neighbour_spacing(std::span<const Vec3f> points) {
  constexpr size_t kNearest = 3;
  const KdTreef tree(points);
  std::vector<float> spacing(points.size(), 0.f);
  parallel_for(points.size(), 256, [&](size_t i) {
    thread_local std::vector<KdTreef::Near> near;
    tree.nearest_others(static_cast<uint32_t>(i), kNearest, near);
    double sum = 0;
    for (const KdTreef::Near& n : near) sum += n.squared_distance;
    if (!near.empty()) spacing[i] = static_cast<float>(std::sqrt(sum / double(near.size())));
  });
  return spacing;
}

}  // namespace vitrine
