#include "stages/sfm/moved_region.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/parallel.h"
#include "core/camera/projection.h"
#include "stages/sfm/passes.h"
#include "stages/sfm/point_filter.h"

namespace vitrine {

namespace {

constexpr double kSameDirection = 0.966;                    // cosine of 15 degrees
constexpr double kSameDistance = 1.4;                       // ratio
constexpr size_t kFewestCameras = 2;                        // on each side
constexpr size_t kNeighbourhood = 16;                       // points
constexpr double kFreely = 0.3;                             // of the tracks around a point span the place
constexpr size_t kFewestMoved = 100, kFewestStanding = 50;  // points
constexpr double kLeastMoved = 0.1;                         // of the points that cameras on both sides look at

// Of each point the photos, in name order: which see it, and which look at it as one of these does.
struct Visibility {
  std::vector<std::vector<uint8_t>> sees, looks;  // [point][photo]
};

Visibility visibility_of(const ColmapModel& model) {
  const size_t photos = model.images.size();
  std::vector<View> views;  // without distortion, which moves nothing by a tenth of the picture
  std::vector<Vec3d> centres;
  std::map<uint32_t, size_t> index;
  for (const ColmapImage& image : model.images) {
    index[image.id] = views.size();
    View& view = views.emplace_back();
    view.cam_from_world = image.cam_from_world();
    view.intrinsics = pinhole_part(*model.find_camera(image.camera_id));
    centres.push_back(view.centre_in_world());
  }
  Visibility v;
  v.sees.resize(model.points.size()), v.looks.resize(model.points.size());
  parallel_for(model.points.size(), 64, [&](size_t i) {
    const ColmapPoint3D& point = model.points[i];
    std::vector<uint8_t>&sees = v.sees[i], &looks = v.looks[i];
    sees.assign(photos, 0);
    for (const ColmapTrackElement& t : point.track) sees[index.at(t.image_id)] = 1;
    looks = sees;
    for (size_t p = 0; p < photos; ++p) {
      if (sees[p]) continue;
      if (!image_point(point.position, views[p])) continue;
      const Vec3d to = point.position - centres[p];
      for (size_t seen = 0; seen < photos && !looks[p]; ++seen) {
        if (!sees[seen]) continue;
        const Vec3d other = point.position - centres[seen];
        const double a = length(to), b = length(other);
        looks[p] = dot(to, other) > kSameDirection * a * b && a < kSameDistance * b && b < kSameDistance * a;
      }
    }
  });
  return v;
}

}  // namespace

std::vector<uint8_t> moved_region(const ColmapModel& model) {
  const size_t photos = model.images.size(), points = model.points.size();
  if (photos < 2 * kSmallestPass || points < kFewestMoved + kFewestStanding) return {};
  const Visibility visibility = visibility_of(model);
  std::vector<Vec3d> positions;
  for (const ColmapPoint3D& p : model.points) positions.push_back(p.position);
  const std::vector<std::vector<uint32_t>> around = neighbours(positions, kNeighbourhood);
  std::vector<uint8_t> best;
  size_t most = 0;
  for (size_t place = kSmallestPass; place + kSmallestPass <= photos; ++place) {
    std::vector<uint8_t> looked_at(points), spans(points), moved(points, 0);
    for (size_t i = 0; i < points; ++i) {
      const auto count = [&](const std::vector<uint8_t>& of, size_t from, size_t to) {
        return size_t(std::count(of.begin() + long(from), of.begin() + long(to), 1));
      };
      looked_at[i] = std::min(count(visibility.looks[i], 0, place), count(visibility.looks[i], place, photos)) >= kFewestCameras;
      spans[i] = std::min(count(visibility.sees[i], 0, place), count(visibility.sees[i], place, photos)) > 0;
    }
    size_t all = 0, gone = 0, standing = 0;
    for (size_t i = 0; i < points; ++i) {
      if (!looked_at[i]) continue;
      size_t of = 1, spanning = spans[i];
      for (uint32_t n : around[i]) of += looked_at[n], spanning += looked_at[n] && spans[n];
      ++all;
      if (of > kNeighbourhood / 2 && spanning == 0)
        moved[i] = 1, ++gone;
      else if (double(spanning) > kFreely * double(of))
        ++standing;
    }
    if (gone <= most || gone < kFewestMoved || double(gone) < kLeastMoved * double(all) || standing < kFewestStanding) continue;
    most = gone;
    best = std::move(moved);
  }
  return best;
}

}  // namespace vitrine
