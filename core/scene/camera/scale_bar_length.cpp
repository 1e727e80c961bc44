#include "core/scene/camera/scale_bar_length.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "core/foundation/base/error.h"
#include "core/scene/camera/projection.h"

namespace vitrine {

namespace {

// A mark has an error of about a pixel in photos of 1000 pixels across 20 degrees or more; at 3 degrees that is 1 % of the
// distance.
constexpr double kLeastAngle_rad = 3 * std::numbers::pi / 180;
constexpr double kLargestError_rel = 0.01;  // relative to the longest side; manual marks are within 0.2 %

constexpr const char* kMarkHint =
    "mark the same two ends in the same order in each photo, in pixels of images/<photo> in the output folder";

struct Sighting {
  const View* view = nullptr;
  double x = 0, y = 0;

  Vec3d direction() const { return normalized(view->ray(x, y)); }
};

double largest_angle(std::span<const Sighting> sightings) {
  double largest = 0;
  for (size_t i = 0; i < sightings.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const Vec3d a = sightings[i].direction(), b = sightings[j].direction();
      largest = std::max(largest, std::atan2(length(cross(a, b)), dot(a, b)));
    }
  return largest;
}

// Solves the normal equations by Cramer's rule; regular if two rays are not parallel.
Vec3d nearest_point(std::span<const Sighting> sightings) {
  Mat3d sum{};
  Vec3d right{};
  for (const Sighting& s : sightings) {
    const Vec3d d = s.direction(), c = s.view->centre_in_world();
    const Mat3d across{Vec3d{1, 0, 0} - d.x * d, Vec3d{0, 1, 0} - d.y * d, Vec3d{0, 0, 1} - d.z * d};
    sum = {sum.c0 + across.c0, sum.c1 + across.c1, sum.c2 + across.c2};
    right += across * c;
  }
  const double det = determinant(sum);
  return Vec3d{determinant(Mat3d{right, sum.c1, sum.c2}), determinant(Mat3d{sum.c0, right, sum.c2}),
               determinant(Mat3d{sum.c0, sum.c1, right})} /
         det;
}

const View& view_of(const ScaleBarMark& mark, const std::vector<View>& views, const auto& fail) {
  const auto it = std::ranges::find_if(views, [&](const View& v) { return v.name == mark.photo || v.stem() == mark.photo; });
  if (it == views.end())
    throw fail(fmt::format("no photo with a known camera is called '{}'", mark.photo), "give photos of images/");
  const Intrinsics& k = it->intrinsics;
  if (std::max(mark.x1, mark.x2) > k.width || std::max(mark.y1, mark.y2) > k.height)
    throw fail(fmt::format("an end does not lie in '{}', a photo of {}x{} pixels", it->name, k.width, k.height), kMarkHint);
  return *it;
}

}  // namespace

CardBox card_box(const std::string& text, const std::vector<View>& views) {
  const auto fail = [&](std::string why) {
    return Error(ErrorKind::Usage, "the grey card cannot be found",
                 {.where = "decompose.grey_card = " + text,
                  .why = std::move(why),
                  .hint = "photo:x,y,w,h, pixels of the undistorted photo, for example IMG_0007.jpg:410,220,60,40",
                  .code = "GREY_CARD"});
  };
  const auto card = parse_photo_box(text);
  if (!card) throw fail("behind the photo's name belong four whole numbers: a box at least one pixel wide and high");
  const auto it = std::ranges::find_if(views, [&](const View& v) { return v.name == card->photo || v.stem() == card->photo; });
  if (it == views.end()) throw fail(fmt::format("no photo with a known camera is called '{}'", card->photo));
  const Intrinsics& k = it->intrinsics;
  if (card->width > k.width - card->x || card->height > k.height - card->y)
    throw fail(fmt::format("the box does not lie in the photo of {}x{} pixels", k.width, k.height));
  return {size_t(it - views.begin()), card->x, card->y, card->width, card->height};
}

ScaleBarLength scale_bar_length(const ScaleBar& bar, const std::vector<View>& views, const Passes& passes) {
  std::string photos;
  for (const ScaleBarMark& m : bar.marks) photos += (photos.empty() ? "" : " ") + m.photo;
  const auto fail = [&](std::string why, std::string hint) {
    return Error(ErrorKind::Usage, "the length of the scale bar cannot be found",
                 {.where = photos, .why = std::move(why), .hint = std::move(hint), .code = "SCALE_BAR"});
  };
  std::array<std::vector<Sighting>, 2> ends;
  for (const ScaleBarMark& m : bar.marks) {
    const View& view = view_of(m, views, fail);
    for (const Sighting& other : ends[0])
      if (other.view == &view) throw fail(fmt::format("'{}' is marked twice", view.name), kMarkHint);
    ends[0].push_back({&view, m.x1, m.y1});
    ends[1].push_back({&view, m.x2, m.y2});
  }
  VITRINE_CHECK(bar.marks.size() >= 2, "a scale bar in {} photos", bar.marks.size());
  const size_t pass = pass_of(passes, ends[0][0].view->name);
  for (const Sighting& s : ends[0])
    if (pass_of(passes, s.view->name) != pass)
      throw fail(fmt::format("the object was moved between '{}' and '{}', so that the bar has two places in the scene ({})",
                             ends[0][0].view->name, s.view->name, passes_text(passes)),
                 "mark the bar in photos of one pass");

  ScaleBarLength out;
  out.angle_rad = std::min(largest_angle(ends[0]), largest_angle(ends[1]));
  if (out.angle_rad < kLeastAngle_rad)
    throw fail(fmt::format("its ends are seen from almost one direction: {:.1f} degrees apart, {:.0f} are needed",
                           out.angle_rad * 180 / std::numbers::pi, kLeastAngle_rad * 180 / std::numbers::pi),
               "mark it in another photo that shows it from the side");
  const Vec3d points[2] = {nearest_point(ends[0]), nearest_point(ends[1])};
  double squares = 0, worst_rel = 0, worst_px = 0;
  const View* worst = nullptr;
  for (size_t end = 0; end < 2; ++end)
    for (const Sighting& s : ends[end]) {
      const auto seen = projection(points[end], *s.view);
      if (!seen) throw fail(fmt::format("the lines of sight meet behind the camera of '{}'", s.view->name), kMarkHint);
      const double px = std::hypot(seen->x - s.x, seen->y - s.y), rel = px / s.view->intrinsics.longest_side();
      squares += px * px;
      if (rel >= worst_rel) worst_rel = rel, worst_px = px, worst = s.view;
    }
  out.error_px = std::sqrt(squares / double(2 * bar.marks.size()));
  if (worst_rel > kLargestError_rel)
    throw fail(fmt::format("the marks do not meet: in '{}' the ends lie up to {:.1f} px off the marks", worst->name, worst_px),
               kMarkHint);
  out.scene_units = length(points[1] - points[0]);
  if (!(out.scene_units > 0)) throw fail("both ends are the same point", kMarkHint);
  out.metres_per_unit = bar.length_m / out.scene_units;
  return out;
}

std::string scale_bar_text(const ScaleBarLength& length) {
  return fmt::format("one unit of the scene is {:.4g} m, by the scale bar, {:.1f} px", length.metres_per_unit, length.error_px);
}

}  // namespace vitrine
