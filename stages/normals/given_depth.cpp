#include "stages/normals/given_depth.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/quantile.h"
#include "core/intake/depth/depth_files.h"
#include "core/intake/poses/photo_orientation.h"
#include "core/observe/stereo/known_depth.h"
#include "core/scene/camera/projection.h"
#include "core/scene/camera/scene_info.h"

namespace vitrine {

namespace {

constexpr double kMostSpread = 0.2, kSmallSpread = 0.03;  // of the ratios
constexpr double kExplained = 0.5;                        // of the spread of the points' depths
constexpr double kOtherScale = 0.1;                       // of one photo against all
constexpr size_t kFewestOfPhoto = 8;                      // ratios that determine the scale of one map
constexpr float kFlat = 1.05f;                            // largest ratio of the depths around a point: no edge

// The map at the undistorted photo, at most `max_side` large and not finer than the file. Depths are along the axis of the
// camera, which undistortion keeps.
ImageF undistorted_depth(const ImageF& depth, const Undistortion& u, bool straight, int max_side) {
  const double scale = straight ? 1 : double(u.source.width) / u.target.width;
  const int own = int(std::lround(std::max(depth.width(), depth.height()) / scale));
  const Intrinsics k = u.target.limited_to(std::max(std::min(max_side, own), 1));
  if (straight) return resized_depth(depth, k.width, k.height);
  const double sx = depth.width() / double(u.source.width), sy = depth.height() / double(u.source.height);
  const double wx = sx * u.target.width / k.width, wy = sy * u.target.height / k.height;
  ImageF out(k.width, k.height, 1);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const Vec3d ray = k.ray(x + 0.5, y + 0.5);
      const Vec2d from = u.identity ? Vec2d{(x + 0.5) * u.target.width / k.width, (y + 0.5) * u.target.height / k.height}
                                    : project(u.source, {ray.x, ray.y});
      out.at(x, y) = depth_near(depth, from.x * sx, from.y * sy, wx, wy);
    }
  return out;
}

ImageF map_of_view(const fs::path& file, double unit, const Undistortion& u, int max_side) {
  const ImageF depth = read_depth(file, unit);
  const int w = depth.width(), h = depth.height(), photo_w = int(u.source.width), photo_h = int(u.source.height);
  const bool straight = w == u.target.width && h == u.target.height && !(w == photo_w && h == photo_h);
  if (!straight && !same_depth_shape(w, h, photo_w, photo_h)) throw_wrong_depth_size(file, depth, photo_w, photo_h);
  return undistorted_depth(depth, u, straight, max_side);
}

// Value of the map at a point; 0 at an edge and where it is unknown.
double flat_depth(const ImageF& map, double x, double y) {
  const int cx = int(x), cy = int(y);
  if (cx < 1 || cy < 1 || cx + 1 >= map.width() || cy + 1 >= map.height()) return 0;
  float nearest = map.at(cx, cy), farthest = nearest;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      nearest = std::min(nearest, map.at(cx + dx, cy + dy));
      farthest = std::max(farthest, map.at(cx + dx, cy + dy));
    }
  return nearest > 0 && farthest < kFlat * nearest ? double(map.at(cx, cy)) : 0;
}

std::vector<DepthRatio> ratios_to_points(const ViewSet& set, std::span<const ImageF> maps) {
  std::vector<DepthRatio> ratios;
  for (const ScenePoint& point : set.points)
    for (const uint32_t v : point.views) {
      if (maps[v].empty()) continue;
      View view = set.views[v];
      view.intrinsics = view.intrinsics.scaled_to(maps[v].width(), maps[v].height());
      const auto at = image_point(point.position, view);
      if (!at) continue;
      if (const double value = flat_depth(maps[v], at->x, at->y); value > 0) ratios.push_back({v, at->z, value});
    }
  return ratios;
}

double spread_of(std::vector<double> values) {
  const double middle = median(values);
  for (double& v : values) v = std::abs(v - middle);
  return kSigmaPerDeviation * median(values);
}

}  // namespace

bool DepthScale::plausible() const { return spread <= kMostSpread && spread <= std::max(kSmallSpread, kExplained * of_points); }

std::optional<DepthScale> depth_scale(std::span<const DepthRatio> ratios, size_t views) {
  if (ratios.size() < kFewestRatios) return std::nullopt;
  std::vector<double> all, depths;
  std::vector<std::vector<double>> own(views);
  for (const DepthRatio& r : ratios) {
    depths.push_back(std::log(r.z));
    all.push_back(std::log(r.z / r.value));
    own[r.view].push_back(all.back());
  }
  const double middle = median(all);
  DepthScale scale{.scale = std::exp(middle),
                   .spread = spread_of(all),
                   .of_points = spread_of(depths),
                   .other_scale = std::vector<uint8_t>(views, 0)};
  for (size_t v = 0; v < views; ++v)
    scale.other_scale[v] = own[v].size() >= kFewestOfPhoto && std::abs(median(own[v]) - middle) > kOtherScale;
  return scale;
}

std::optional<GivenDepth> given_depth(const fs::path& depth, const fs::path& sfm, const ViewSet& set, int max_side,
                                      Notes& notes) {
  const DepthFolder folder(depth);
  const PhotoLenses lenses = read_photo_lenses(sfm, set);
  std::vector<std::string> photos;
  for (const View& view : set.views) photos.push_back(view.name);
  const auto files = folder.match(photos);
  GivenDepth given{.maps = std::vector<ImageF>(photos.size())};
  parallel_for(photos.size(), 1, [&](size_t v) {
    if (files[v] && interrupt_signal() == 0)
      given.maps[v] = map_of_view(*files[v], folder.unit(), lenses.undistortions[v], max_side);
  });
  throw_if_interrupted();
  if (const auto without = std::count(files.begin(), files.end(), std::nullopt); without > 0)
    notes.push_back({"DEPTH_INCOMPLETE", fmt::format("{} of {} photos have no depth map", without, photos.size())});

  const std::vector<DepthRatio> ratios = ratios_to_points(set, given.maps);
  given.ratios = ratios.size();
  const auto metres = read_scene_info(sfm / "scene.json").metres_per_unit();
  const auto solved = depth_scale(ratios, photos.size());
  if (!solved && !metres) {
    notes.push_back(
        {"DEPTH_SCALE_UNKNOWN",
         fmt::format("the depth maps are not used: {} sparse points in them are too few for their scale ({} are needed), "
                     "and the poses have no known unit",
                     ratios.size(), kFewestRatios)});
    return std::nullopt;
  }
  if (solved && !solved->plausible()) {
    notes.push_back(
        {"DEPTH_DISAGREES",
         fmt::format("the depth maps are not used: their ratios to {} sparse points spread by {:.0f} %, the depths of these "
                     "points by {:.0f} %; the maps are relative or inverse depths, or of other photos",
                     ratios.size(), 100 * solved->spread, 100 * solved->of_points)});
    return std::nullopt;
  }
  given.from_frame = !solved;
  given.units_per_metre = solved ? solved->scale : 1 / *metres;
  given.spread = solved ? solved->spread : 0;
  for (size_t v = 0; v < photos.size(); ++v) {
    if (solved && solved->other_scale[v]) given.maps[v] = ImageF(), ++given.other_scale;
    given.photos += !given.maps[v].empty();
    for (float& z : given.maps[v].data()) z = static_cast<float>(z * given.units_per_metre);
  }
  if (given.other_scale > 0)
    notes.push_back({"DEPTH_PHOTOS_LEFT_OUT",
                     fmt::format("{} depth maps are not used: their scale differs from that of the others by more than {:.0f} %",
                                 given.other_scale, 100 * kOtherScale)});
  return given;
}

}  // namespace vitrine
