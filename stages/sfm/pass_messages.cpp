#include "stages/sfm/pass_messages.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/log.h"
#include "core/math/quantile.h"
#include "stages/sfm/normalize.h"

namespace vitrine {

namespace {

constexpr double kStepOfMatches = 2.0 / 3;  // of the angle below which nine of ten matching pairs are apart

// Photos between the lowest ones of two passes, in steps that still match; by how far the object's features match, and as if it
// was turned upside down.
size_t photos_between(const ColmapModel& model, const Vec3d& up, double furthest_match) {
  std::vector<double> elevations;
  for (const ColmapImage& image : model.images)
    elevations.push_back(
        std::asin(std::clamp(-dot(transposed_times(image.cam_from_world().rotation, Vec3d{0, 0, 1}), up), -1.0, 1.0)));
  const double lowest = quantile_of(elevations, 0.1) * 180 / std::numbers::pi;
  return size_t(std::clamp(std::ceil(2 * lowest / std::max(kStepOfMatches * furthest_match, 5.0)) - 1, 1.0, 20.0));
}

}  // namespace

void report_passes(const ObjectPasses& passes, const ColmapModel& model, const std::string& up, StageContext& context) {
  context.metric("passes", double(std::max<size_t>(passes.passes.size(), 1)));
  if (passes.passes.empty()) return;
  make_folders(context.output() / "sfm");
  write_passes(context.output(), passes.passes, passes.poses);
  switch (passes.poses) {
    case PosesOf::Object:
      log_info(
          "sfm: {}: the object was moved between them, its own features join them; what surrounds it is no part of the scene",
          passes_text(passes.passes));
      return;
    case PosesOf::LargestPass:
      context.warning(
          "SFM_PASSES_NOT_JOINED",
          fmt::format("{} that share too little of the object: the largest pass is reconstructed. About {} photos are "
                      "missing in between: from lower down, or of the object on its side, in steps of {:.0f} degrees",
                      passes_text(passes.passes), photos_between(model, scene_up(model, up).up, passes.furthest_match),
                      kStepOfMatches * passes.furthest_match));
      return;
    case PosesOf::Surroundings:
      context.warning(
          "SFM_OBJECT_TURNED",
          fmt::format("{}: something that they show was moved between them against the rest, and no poses fit both; it "
                      "will stand in the scene more than once. Masks of the object let its own features decide: a folder "
                      "with one for each photo (--masks DIR, DIR/object)",
                      passes_text(passes.passes)));
  }
}

}  // namespace vitrine
