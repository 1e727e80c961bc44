#include "stages/decompose/environment_map.h"

namespace vitrine {

ImageF environment_map(const Surroundings& around, const LightGrid& grid, const LightSolution& solution, const Vec3f& unit) {
  const int h = around.height;
  ImageF out(2 * h, h, 3);
  Vec3d sum{};
  double count = 0;
  for (size_t j = 0; j < solution.light.size(); ++j)
    if (solution.free[j]) sum += cast<double>(solution.light[j]), count += 1;
  const Vec3f mean = count > 0 ? cast<float>(sum / count) : Vec3f{};
  for (size_t t = 0; t < out.pixel_count(); ++t) {
    const size_t cell = grid.cell_of(around.direction(t));
    Vec3f value = solution.free[cell] ? solution.light[cell] : mean;
    if (around.seen(t))
      for (size_t c = 0; c < 3; ++c) value[c] = around.radiance[t][c] / unit[c];
    for (size_t c = 0; c < 3; ++c) out.data()[3 * t + c] = value[c];
  }
  return out;
}

}  // namespace vitrine
