#include "stages/tomography/page_volume.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "stages/page_text.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kLarger = 1.005;  // factor by which cells grow until few enough are left

std::array<int, 3> size_of(const std::array<int, 3>& size, double factor) {
  std::array<int, 3> out{};
  for (size_t c = 0; c < 3; ++c) out[c] = std::max(1, int(std::ceil(double(size[c]) / factor - 1e-9)));
  return out;
}

size_t count_of(const std::array<int, 3>& size) { return size_t(size[0]) * size_t(size[1]) * size_t(size[2]); }

// Along one axis only; origin and cell stay.
VoxelGrid<float> averaged_along(const VoxelGrid<float>& from, size_t axis, double factor, int size) {
  VoxelGrid<float> out{.origin = from.origin, .cell = from.cell, .size = from.size, .values = {}};
  out.size[axis] = size;
  out.values.resize(out.count());
  size_t stride = 1;
  for (size_t c = 0; c < axis; ++c) stride *= size_t(from.size[c]);
  out.each([&](int x, int y, int z) {
    std::array<int, 3> cell{x, y, z};
    const double begin = cell[axis] * factor, end = std::min(begin + factor, double(from.size[axis]));
    const int first = int(begin);
    cell[axis] = first;
    const float* value = &from.values[from.index(cell[0], cell[1], cell[2])];
    double sum = 0;
    for (int i = first; i < end; ++i, value += stride)
      sum += double(*value) * (std::min(end, double(i + 1)) - std::max(begin, double(i)));
    out.values[out.index(x, y, z)] = float(sum / (end - begin));
  });
  return out;
}

Json numbers(const std::array<int, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace

VoxelGrid<float> averaged_volume(const VoxelGrid<float>& volume, size_t most) {
  if (volume.count() <= most) return volume;
  double factor = std::cbrt(double(volume.count()) / double(most));
  while (count_of(size_of(volume.size, factor)) > most) factor *= kLarger;
  const std::array<int, 3> size = size_of(volume.size, factor);
  VoxelGrid<float> out = averaged_along(volume, 2, factor, size[2]);
  for (size_t axis = 0; axis < 2; ++axis) out = averaged_along(out, axis, factor, size[axis]);
  out.cell *= factor;
  return out;
}

PageVolume page_volume(const VoxelGrid<float>& volume) {
  PageVolume out{.steps = {.origin = volume.origin, .cell = volume.cell, .size = volume.size, .values = {}}};
  const auto [low, high] = std::ranges::minmax(volume.values);
  out.low = low, out.high = high;
  const double scale = high > low ? kPageSteps / (double(high) - double(low)) : 0;
  out.steps.values.resize(volume.count());
  std::ranges::transform(volume.values, out.steps.values.begin(),
                         [&](float v) { return uint16_t(std::lround((double(v) - double(low)) * scale)); });
  return out;
}

std::string packed_steps(const VoxelGrid<uint16_t>& steps) {
  const size_t n = steps.count();
  std::string out(2 * n, '\0');
  for (size_t i = 0; i < n; ++i) out[i] = char(steps.values[i] & 255), out[n + i] = char(steps.values[i] >> 8);
  return out;
}

size_t write_volume_page(const fs::path& path, const std::string& page, const VoxelGrid<float>& volume,
                         const VolumePageDesc& desc) {
  const PageVolume v = page_volume(averaged_volume(volume, desc.most_cells));
  const Vec3d& o = v.steps.origin;
  const Json head{{"format", 1},
                  {"unit", desc.unit},
                  {"size", numbers(v.steps.size)},
                  {"cell", v.steps.cell},
                  {"origin", {o.x, o.y, o.z}},
                  {"end", {volume.high().x, volume.high().y, volume.high().z}},
                  {"steps", kPageSteps},
                  {"low", v.low},
                  {"high", v.high},
                  {"iso", desc.iso},
                  {"radius", desc.seen ? Json(desc.seen->radius) : Json(nullptr)},
                  {"scan_size", numbers(volume.size)},
                  {"scan_cell", volume.cell}};
  const std::string text = page_of(page, {json_part("head", head), bytes_part("steps", deflated(packed_steps(v.steps)))});
  write_file(path, text);
  return text.size();
}

void write_volume_page(const fs::path& path, const VoxelGrid<float>& volume, const VolumePageDesc& desc, StageContext& context) {
  std::error_code ec;
  if (!fs::exists(empty_page_path("tomography"), ec)) {
    context.warning("NO_PAGE",
                    "this build of vitrine has no page to view a volume in: page.html is missing (npm was missing when "
                    "it was built)");
    return;
  }
  const size_t bytes = write_volume_page(path, empty_page("tomography", "to view a volume in"), volume, desc);
  context.metric("page_bytes", double(bytes));
}

}  // namespace vitrine
