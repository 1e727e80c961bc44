#include "stages/sfm/gains/principal_point.h"

#include <algorithm>
#include <cmath>

#include "stages/sfm/gains/bundle.h"

namespace vitrine {

namespace {

constexpr size_t kFewestImages = 12, kFewestObservations = 3000;
constexpr double kBetter = 0.97;    // of the error before: any free parameter gains a per cent if the lens model is wrong
constexpr double kFurthest = 0.04;  // of the longest side
constexpr double kFocalChange = 0.1;

// True if all lenses are plausible.
bool sane(const ColmapModel& before, const ColmapModel& after, double& furthest) {
  bool fine = true;
  for (size_t c = 0; c < after.cameras.size(); ++c) {
    const ColmapCamera &a = before.cameras[c], &b = after.cameras[c];
    const size_t focals = focal_count(b);
    const double side = double(std::max(b.width, b.height));
    const double off = std::hypot(b.params[focals] - 0.5 * double(b.width), b.params[focals + 1] - 0.5 * double(b.height)) / side;
    furthest = std::max(furthest, off);
    fine &= off <= kFurthest && std::abs(b.params[0] / a.params[0] - 1) <= kFocalChange;
  }
  return fine;
}

}  // namespace

PrincipalPoints refine_principal_points(ColmapModel& model) {
  PrincipalPoints result;
  if (!bundle_supports(model) || model.images.size() < kFewestImages) return result;
  ColmapModel trial = model;
  BundleAdjustment adjustment(trial);
  result.asked = adjustment.observations() >= kFewestObservations;
  if (!result.asked) return result;
  result.error_before = adjustment.solve(false);
  result.error_after = adjustment.solve(true);
  if (!sane(model, trial, result.furthest) || !(result.error_after <= kBetter * result.error_before)) return result;
  adjustment.finish();
  model = std::move(trial);
  result.moved = true;
  return result;
}

}  // namespace vitrine
