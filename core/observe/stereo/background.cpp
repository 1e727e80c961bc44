#include "core/observe/stereo/background.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr int kPredictedAround = 3;  // margin in pixels around the silhouette that is also predicted, for the windows
constexpr int kWindow = 2;           // half side of the window whose mean error selects the surface
constexpr float kMostError = 3;      // per-pixel clamp in that mean
constexpr size_t kMostPlanes = 3;
constexpr size_t kFewestWitnesses = 2, kMostWitnesses = 15;
constexpr size_t kMostMaps = 48;            // number of photos whose depth maps are used
constexpr double kOtherDepth = 0.04;        // relative depth difference of another surface
constexpr double kTouches = 0.99;           // of the depth where a ray leaves the hull: includes the surface under the object
constexpr float kPredictionNoise = 0.035f;  // sRGB, mean of the channels
constexpr float kHalfPixel = 0.5f;          // misregistration of predictions
constexpr double kThin = 0.3;               // of half the diagonal of the hull
constexpr double kCutReach = 2;             // distance from a plane's centre, in its extents, within which it cuts the hull
constexpr double kCutShare = 0.03;          // minimum share of all surfaces for a supporting plane
constexpr double kOneSide = 0.95;           // share of the cameras on one side
constexpr double kParallel = 0.95;          // cosine between normals

using Colour = std::array<float, 3>;

// Background prediction for one photo, behind a visual hull or for the whole photo.
class Behind {
 public:
  Behind(const Surroundings& scene, size_t index)
      : scene_(scene),
        index_(index),
        photo_(scene.photos[index]),
        world_from_cam_(inverse(photo_.view.cam_from_world)),
        width_(photo_.view.intrinsics.width),
        height_(photo_.view.intrinsics.height),
        least_(size_t(width_) * size_t(height_), std::numeric_limits<float>::min()),
        nearest_(scene.photos.size()) {
    for (size_t o = 0; o < nearest_.size(); ++o) nearest_[o] = o;
    std::ranges::stable_sort(
        nearest_, {}, [&](size_t o) { return length(scene.photos[o].view.centre_in_world() - world_from_cam_.translation); });
  }

  Behind(const Surroundings& scene, const VisualHull& hull, std::span<const HullDepths> passed, size_t index)
      : Behind(scene, index) {
    hull_ = &hull;
    passed_ = passed;
    thin_ = kThin * 0.5 * length(hull.bounds().high - hull.bounds().low);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        float& z = least_[at(x, y)] = passed[index].exit[at(x, y)];
        if (z > 0) continue;
        for (int v = std::max(0, y - kPredictedAround); v <= std::min(height_ - 1, y + kPredictedAround); ++v)
          for (int u = std::max(0, x - kPredictedAround); u <= std::min(width_ - 1, x + kPredictedAround); ++u)
            z = std::max(z, passed[index].exit[at(u, v)]);
      }
  }

  bool anything() const {
    return std::ranges::any_of(least_, [](float z) { return z > 0; });
  }

  // For each requested pixel, the candidate with the lowest mean error in its window.
  Explanation best() const {
    const size_t pixels = least_.size();
    Explanation found{std::vector<float>(pixels, -1.f), std::vector<float>(pixels, -1.f), std::vector<float>(pixels, 0.f)};
    for (const std::vector<float>& depth : choices()) {
      const std::vector<float> error = errors(depth);
      for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
          const size_t i = at(x, y);
          if (error[i] < 0) continue;
          if (const float mean = mean_around(error, x, y); found.around[i] < 0 || mean < found.around[i])
            found.around[i] = mean, found.error[i] = error[i], found.depth[i] = depth[i];
        }
    }
    return found;
  }

 private:
  // [choice][h,w] z-depths, 0 = none: stereo surface, planes from near to far, far background.
  std::vector<std::vector<float>> choices() const {
    std::vector<std::vector<float>> depth(kMostPlanes + 2, std::vector<float>(least_.size(), 0.f));
    depth[0] = measured();
    struct SeenPlane {  // in the camera frame
      Vec3d normal, centre;
      double offset, reach;
      bool floor;
    };
    const Rigid& pose = photo_.view.cam_from_world;
    std::vector<SeenPlane> planes;
    for (const ScenePlane& plane : scene_.planes) {
      const Vec3d normal = pose.rotation * plane.normal;
      planes.push_back({normal, pose * plane.centre, plane.offset + dot(normal, pose.translation), plane.reach(), plane.floor});
    }
    std::vector<std::pair<double, bool>> hits;  // z, whether the plane is opaque (a floor)
    for (size_t i = 0; i < least_.size(); ++i) {
      if (least_[i] == 0) continue;
      const Vec3d ray = ray_of(i);
      hits.clear();
      for (const SeenPlane& plane : planes) {
        const double z = plane.offset / dot(plane.normal, ray);
        if (z > kTouches * double(least_[i]) && length(z * ray - plane.centre) <= plane.reach) hits.emplace_back(z, plane.floor);
      }
      std::ranges::sort(hits);
      bool ended = false;
      for (size_t h = 0; h < std::min(hits.size(), kMostPlanes) && !ended; ++h)
        depth[1 + h][i] = float(hits[h].first), ended = hits[h].second;
      if (!ended) depth.back()[i] = float(scene_.far);
    }
    return depth;
  }

  // [h,w] errors of a choice; below 0: unknown.
  std::vector<float> errors(const std::vector<float>& depth) const {
    std::vector<Colour> colour(depth.size());
    std::vector<uint8_t> known(depth.size(), 0);
    for (size_t i = 0; i < depth.size(); ++i) {
      if (!(depth[i] > 0)) continue;
      if (const auto c = median_colour(world_from_cam_ * (double(depth[i]) * ray_of(i)))) colour[i] = *c, known[i] = 1;
    }
    std::vector<float> error(depth.size(), -1.f);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const size_t i = at(x, y);
        if (!known[i]) continue;
        float sum = 0;
        for (size_t c = 0; c < 3; ++c) {
          float low = colour[i][c], high = low;
          for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
            if (x + dx < 0 || y + dy < 0 || x + dx >= width_ || y + dy >= height_ || !known[at(x + dx, y + dy)]) continue;
            const float half = colour[i][c] + kHalfPixel * (colour[at(x + dx, y + dy)][c] - colour[i][c]);
            low = std::min(low, half), high = std::max(high, half);
          }
          const float p = photo_.srgb.data()[3 * i + c];
          sum += std::max({0.f, low - p, p - high});
        }
        error[i] = sum / 3 / kPredictionNoise;
      }
    return error;
  }

  // Mean of the known errors in the window of a pixel.
  float mean_around(const std::vector<float>& error, int x, int y) const {
    float sum = 0, count = 0;
    for (int v = std::max(0, y - kWindow); v <= std::min(height_ - 1, y + kWindow); ++v)
      for (int u = std::max(0, x - kWindow); u <= std::min(width_ - 1, x + kWindow); ++u)
        if (const float e = error[at(u, v)]; e >= 0) sum += std::min(e, kMostError), ++count;
    return sum / count;
  }

  size_t at(int x, int y) const { return size_t(y) * size_t(width_) + size_t(x); }
  Vec3d ray_of(size_t pixel) const {
    return photo_.view.intrinsics.ray(double(pixel % size_t(width_)) + 0.5, double(pixel / size_t(width_)) + 0.5);
  }

  // Nearest surface behind the hull in the depth maps of the other photos.
  std::vector<float> measured() const {
    std::vector<float> nearest(least_.size(), 0.f);
    const size_t stride = (nearest_.size() + kMostMaps - 1) / kMostMaps;
    for (size_t n = 0; n < nearest_.size(); n += stride) {
      const size_t o = nearest_[n];
      const DepthMap& map = scene_.maps[o];
      if (map.zdepth.empty() || (hull_ != nullptr && o == index_)) continue;
      const Rigid between = photo_.view.cam_from_world * inverse(scene_.photos[o].view.cam_from_world);
      const Intrinsics& k = scene_.photos[o].view.intrinsics;
      for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
          const size_t i = map.index(x, y);
          if (!map.reliable(i)) continue;
          const Vec3d p = between * (double(map.zdepth[i]) * k.ray(x + 0.5, y + 0.5));
          const auto seen = image_point(p, photo_.view.intrinsics);
          if (!seen) continue;
          const size_t j = at(int(seen->x), int(seen->y));
          if (least_[j] == 0 || seen->z < double(least_[j]) || (nearest[j] > 0 && seen->z >= double(nearest[j]))) continue;
          if (hull_ == nullptr || hull_->carved().at(world_from_cam_ * p) == 0) nearest[j] = float(seen->z);
        }
    }
    return nearest;
  }

  // Median over the nearest photos that see the point unoccluded by the hull or a stereo surface.
  std::optional<Colour> median_colour(const Vec3d& point) const {
    std::array<std::array<float, kMostWitnesses>, 3> seen{};
    size_t count = 0;
    for (const size_t o : nearest_) {
      if (o == index_) continue;
      const EdgePhoto& other = scene_.photos[o];
      const auto p = image_point(point, other.view, 0, 0.5);
      if (!p) continue;
      const size_t pixel = size_t(int(p->y)) * size_t(other.view.intrinsics.width) + size_t(int(p->x));
      if (!passed_.empty())
        if (const float entry = passed_[o].entry[pixel]; entry > 0 && p->z > double(entry) + thin_) continue;
      const DepthMap& map = scene_.maps[o];
      if (!map.zdepth.empty() && map.reliable(pixel) && p->z > (1 + kOtherDepth) * double(map.zdepth[pixel])) continue;
      Colour colour{};
      sample_bilinear(other.srgb, p->x, p->y, colour.data());
      for (size_t c = 0; c < 3; ++c) seen[c][count] = colour[c];
      if (++count == kMostWitnesses) break;
    }
    if (count < kFewestWitnesses) return std::nullopt;
    Colour median{};
    for (size_t c = 0; c < 3; ++c) {
      std::sort(seen[c].begin(), seen[c].begin() + std::ptrdiff_t(count));
      median[c] = 0.5f * (seen[c][(count - 1) / 2] + seen[c][count / 2]);
    }
    return median;
  }

  const Surroundings& scene_;
  const VisualHull* hull_ = nullptr;
  std::span<const HullDepths> passed_;
  double thin_ = 0;  // tolerated path length through the hull, whose surface is inexact
  size_t index_;
  const EdgePhoto& photo_;
  Rigid world_from_cam_;
  int width_, height_;
  std::vector<float> least_;     // [h,w] minimum background depth; 0: not requested
  std::vector<size_t> nearest_;  // photo indices sorted by camera distance
};

}  // namespace

HullDepths hull_depths(const VisualHull& hull, const View& view) {
  const size_t pixels = view.intrinsics.pixel_count();
  HullDepths depths{std::vector<float>(pixels, 0.f), std::vector<float>(pixels, 0.f)};
  const VoxelGrid<uint8_t>& grid = hull.carved();
  const Bounds3& box = hull.bounds();
  // `direction` has z = 1 in the camera frame: t is the depth.
  mask_of_rays(view, [&](size_t pixel, const Vec3d& eye, const Vec3d& direction) {
    double begin = 0, end = 1e300;
    for (size_t a = 0; a < 3; ++a) {
      const double t = (box.low[a] - eye[a]) / direction[a], u = (box.high[a] - eye[a]) / direction[a];
      begin = std::max(begin, std::min(t, u)), end = std::min(end, std::max(t, u));
    }
    const double step = 0.5 * grid.cell / length(direction);
    for (double t = begin; t < end; t += step) {
      if (grid.at(eye + t * direction) == 0) continue;
      if (depths.entry[pixel] == 0) depths.entry[pixel] = float(t);
      depths.exit[pixel] = float(t);
    }
    return false;
  });
  return depths;
}

Explanation explanation(const Surroundings& scene, size_t index) { return Behind(scene, index).best(); }

std::vector<float> unexplained(const Surroundings& scene, const VisualHull& hull, std::span<const HullDepths> passed,
                               size_t index) {
  const Behind behind(scene, hull, passed, index);
  if (!behind.anything()) return std::vector<float>(passed[index].exit.size(), -1.f);
  std::vector<float> error = behind.best().error;
  for (size_t i = 0; i < error.size(); ++i)
    if (passed[index].exit[i] == 0) error[i] = -1;
  return error;
}

std::vector<uint8_t> hidden_pixels(const DepthMap& map, const HullDepths& passed) {
  std::vector<uint8_t> hidden(passed.entry.size(), 0);
  if (map.zdepth.empty()) return hidden;
  for (size_t i = 0; i < hidden.size(); ++i)
    hidden[i] = passed.entry[i] > 0 && map.reliable(i) && double(map.zdepth[i]) < (1 - kOtherDepth) * double(passed.entry[i]);
  return hidden;
}

std::vector<HalfSpace> sides_of_cameras(std::span<const ScenePlane> planes, std::span<const View> views, const Bounds3& hull) {
  std::vector<HalfSpace> sides;
  const Vec3d middle = 0.5 * (hull.low + hull.high);
  const double radius = 0.5 * length(hull.high - hull.low);
  for (const ScenePlane& plane : planes) {
    const double off = dot(plane.normal, middle) - plane.offset;
    if (std::abs(off) > radius || plane.share < kCutShare || plane.extent < radius) continue;
    if (length(middle - off * plane.normal - plane.centre) > kCutReach * plane.extent) continue;
    const auto above = double(
        std::ranges::count_if(views, [&](const View& view) { return dot(plane.normal, view.centre_in_world()) > plane.offset; }));
    if (above > kOneSide * double(views.size())) sides.push_back({-1.0 * plane.normal, -plane.offset});
    if (above < (1 - kOneSide) * double(views.size())) sides.push_back({plane.normal, plane.offset});
  }
  // An object next to a pedestal may stand on the table: of nearly parallel planes, keep the one that leaves the most.
  std::vector<HalfSpace> widest;
  for (const HalfSpace& side : sides)
    if (std::ranges::none_of(sides, [&](const HalfSpace& other) {
          return dot(other.normal, side.normal) > kParallel && other.offset > side.offset;
        }))
      widest.push_back(side);
  return widest;
}

}  // namespace vitrine
