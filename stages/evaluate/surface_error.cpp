#include "stages/evaluate/surface_error.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace vitrine {

double mean(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (double v : values) sum += v;
  return sum / double(values.size());
}

void add_surface_error(const ViewPicture& ours, const SurfaceTruth& truth, const Similarity& truth_from_ours, const ImageF* mask,
                       SurfaceError& sum) {
  const auto normal_of = [](const ImageF& image, size_t i) {
    const float* n = image.data().data() + 3 * i;
    return Vec3d{n[0], n[1], n[2]};
  };
  for (size_t i = 0; i < ours.zdepth.pixel_count(); ++i) {
    const double z = ours.zdepth.data()[i];
    if (!(z > 0) || (mask != nullptr && !(mask->data()[i] > 0))) continue;
    if (!truth.zdepth.empty() && truth.zdepth.data()[i] > 0) {
      const double zt = truth.zdepth.data()[i];
      sum.zdepth_rel.push_back(std::abs(truth_from_ours.scale * z - zt) / zt);
    }
    if (truth.normal.empty()) continue;
    const Vec3d a = normal_of(ours.normal_in_world, i), b = normal_of(truth.normal, i);
    if (squared_length(a) == 0 || squared_length(b) == 0) continue;
    const Vec3d turned = truth_from_ours.rotation * a;
    const double angle = std::atan2(length(cross(turned, b)), dot(turned, b)) * 180 / std::numbers::pi;
    sum.normal_deg.push_back(angle);
  }
}

}  // namespace vitrine
