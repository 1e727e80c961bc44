#include "core/scene/camera/colmap_lens.h"

#include <algorithm>
#include <cmath>

namespace vitrine {

namespace {

// `from` is `to` when the parameters [first, first + count) are zero; `to` takes the parameters before `first`.
struct Reduction {
  std::string_view from, to;
  size_t first, count;
};
constexpr Reduction kReductions[] = {
    {"FULL_OPENCV", "OPENCV", 8, 4},  // k3 k4 k5 k6
    {"OPENCV", "PINHOLE", 4, 4},      // k1 k2 p1 p2
    {"FOV", "PINHOLE", 4, 1},         // omega
    {"DIVISION", "PINHOLE", 4, 1},    // k
    {"EUCM", "PINHOLE", 4, 1},        // alpha; beta has no effect then
    {"SIMPLE_DIVISION", "SIMPLE_PINHOLE", 3, 1},
    {"RADIAL", "SIMPLE_RADIAL", 4, 1},  // k2
    {"SIMPLE_RADIAL", "SIMPLE_PINHOLE", 3, 1},
};

// Some programs write what is left of a computation in place of zero. At r = 2 and f = 10000 px this is 1e-4 px.
constexpr double kZero = 1e-10;

}  // namespace

bool has_two_focals(int model_id) {
  const ColmapCameraType* type = colmap_camera_type(model_id);
  if (type == nullptr) return false;
  for (const std::string_view name : {"PINHOLE", "OPENCV", "OPENCV_FISHEYE", "FULL_OPENCV", "FOV", "THIN_PRISM_FISHEYE",
                                      "RAD_TAN_THIN_PRISM_FISHEYE", "DIVISION", "FISHEYE", "EUCM"})
    if (type->name == name) return true;
  return false;
}

bool is_fisheye(int model_id) {
  const ColmapCameraType* type = colmap_camera_type(model_id);
  return type != nullptr && (type->name == "FOV" || type->name.find("FISHEYE") != std::string_view::npos);
}

ColmapCamera simplest_camera(ColmapCamera camera) {
  for (const Reduction& r : kReductions) {
    const ColmapCameraType* type = colmap_camera_type(camera.model_id);
    if (type == nullptr || type->name != r.from || camera.params.size() != type->parameter_count) continue;
    const auto first = camera.params.begin() + long(r.first);
    if (!std::all_of(first, first + long(r.count), [](double k) { return std::abs(k) <= kZero; })) continue;
    const ColmapCameraType& to = *colmap_camera_type(r.to);
    camera.model_id = to.id;
    camera.params.resize(to.parameter_count);
  }
  return camera;
}

}  // namespace vitrine
