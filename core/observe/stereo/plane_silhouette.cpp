#include "core/observe/stereo/plane_silhouette.h"

#include <algorithm>
#include <optional>

#include "core/observe/stereo/silhouette.h"
#include "core/scene/camera/projection.h"

namespace vitrine {

namespace {

constexpr double kNearest_rel = 1e-3;     // of the rectangle's size: near clipping distance
constexpr double kLeastShown = 0.0006;    // of the picture: minimum visible area
constexpr double kLeastKnown = 0.3;       // minimum known share of the rectangle's pixels
constexpr double kOwnPiece = 0.3;         // share of a component inside the rectangle from which it belongs to it
constexpr double kAbout = 1.5;            // of the rectangle's size: pixels farther off may belong to other objects
constexpr double kMostOfRectangle = 0.5;  // or share of the rectangle inside the component

}  // namespace

std::array<Vec3d, 4> corners_of(const Plane& plane) {
  const Vec3d u = plane.half.x * plane.axes.c0, v = plane.half.y * plane.axes.c1;
  return {plane.centre - u - v, plane.centre + u - v, plane.centre + u + v, plane.centre - u + v};
}

bool faces(const Plane& plane, const View& view) { return dot(view.centre_in_world() - plane.centre, plane.axes.c2) > 0; }

RowSpans spans_of_plane(const Plane& plane, const View& view) {
  const double nearest = kNearest_rel * plane.size();
  const std::array<Vec3d, 4> corners = corners_of(plane);
  std::vector<Vec2d> polygon;
  for (size_t i = 0; i < 4; ++i) {
    const Vec3d a = view.cam_from_world * corners[i], b = view.cam_from_world * corners[(i + 1) % 4];
    const auto add = [&](const Vec3d& p) {
      const ImagePoint at = projected(p, view.intrinsics);
      polygon.push_back({at.x, at.y});
    };
    if (a.z >= nearest) add(a);
    if ((a.z >= nearest) != (b.z >= nearest)) add(a + (nearest - a.z) / (b.z - a.z) * (b - a));
  }
  if (polygon.size() < 3) return {};
  RowSpans spans = no_spans(view);
  for (size_t i = 0; i < polygon.size(); ++i) add_segment(polygon[i], polygon[(i + 1) % polygon.size()], spans);
  return spans;
}

PlaneMasks::PlaneMasks(std::span<const Silhouette> masks, const Plane& start) {
  struct Photo {
    std::optional<MaskRows> rows;
    double share = 0;
  };
  std::vector<Photo> all(masks.size());
  parallel_for(masks.size(), 1, [&](size_t v) {
    const Silhouette& mask = masks[v];
    if (!faces(start, mask.view)) return;
    const RowSpans spans = spans_of_plane(start, mask.view);
    if (spans.empty()) return;
    const std::vector<uint8_t> inside = pixels_of(spans, mask.view);
    size_t shown = 0, known = 0;
    for (size_t i = 0; i < inside.size(); ++i) shown += inside[i], known += inside[i] && mask.value.data()[i] >= 0;
    if (double(shown) < kLeastShown * double(inside.size()) || double(known) < kLeastKnown * double(shown)) return;
    Silhouette own = mask;
    for (const std::vector<size_t>& piece : mask_pieces(mask).pixels) {
      size_t both = 0;
      for (const size_t i : piece) both += inside[i];
      if (double(both) >= kOwnPiece * double(piece.size()) || double(both) >= kMostOfRectangle * double(known)) continue;
      for (const size_t i : piece) own.value.data()[i] = -1;
    }
    Plane about = start;
    about.half = kAbout * start.half;
    const std::vector<uint8_t> near = pixels_of(spans_of_plane(about, mask.view), mask.view);
    for (size_t i = 0; i < near.size(); ++i)
      if (!near[i]) own.value.data()[i] = -1;
    all[v] = {MaskRows(own), double(shown) / double(inside.size())};
  });
  for (Photo& photo : all) {
    if (!photo.rows) continue;
    if (!photo.rows->says_nothing()) share_ += photo.share;
    photos_.push_back(std::move(*photo.rows));
  }
  share_ /= double(std::max<size_t>(1, marked()));
}

size_t PlaneMasks::marked() const {
  return size_t(std::ranges::count_if(photos_, [](const MaskRows& rows) { return !rows.says_nothing(); }));
}

Vec3d PlaneMasks::mean_camera() const {
  Vec3d sum{};
  for (const MaskRows& rows : photos_) sum += rows.view().centre_in_world();
  return sum / double(std::max<size_t>(1, photos_.size()));
}

}  // namespace vitrine
