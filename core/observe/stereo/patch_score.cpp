#include "core/observe/stereo/patch_score.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace vitrine {

namespace {

constexpr float kBrightnessReach = 0.15f;
constexpr float kUnseenScore = -2;

struct Offsets {
  alignas(32) std::array<float, kPatchLanes> x{}, y{};
};
constexpr Offsets kOffsets = [] {
  Offsets o;
  size_t i = 0;
  for (int y = -kPatchRadius; y <= kPatchRadius; ++y)
    for (int x = -kPatchRadius; x <= kPatchRadius; ++x, ++i) o.x[i] = float(x), o.y[i] = float(y);
  return o;
}();

// Eight partial sums in a fixed order: the same result for any vectorisation.
template <class Term>
float lane_sum(Term&& term) {
  float lanes[8] = {};
  for (size_t i = 0; i < kPatchLanes; i += 8)
    for (size_t l = 0; l < 8; ++l) lanes[l] += term(i + l);
  return ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5])) + ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]));
}

// Samples the warped patch in the other photo; false where it is not visible.
bool carried(const ImageF& other, const Transfer& transfer, const Vec3d& m, double x, double y,
             std::array<float, kPatchLanes>& value) {
  const Mat3d& a = transfer.rotation_part;
  const Vec3d& b = transfer.translation_part;
  // Columns of the homography, and the projection of the patch centre.
  const Vec3d h0 = a.c0 + m.x * b, h1 = a.c1 + m.y * b, h2 = a.c2 + m.z * b;
  const Vec3d centre = x * h0 + y * h1 + h2;
  const double reach = kPatchRadius * (std::abs(h0.z) + std::abs(h1.z));
  if (!(centre.z > 1e-9) || !(centre.z > 2 * reach)) return false;
  const double u0 = centre.x / centre.z, v0 = centre.y / centre.z;
  const int width = other.width(), height = other.height();
  if (!(u0 >= 1 && v0 >= 1 && u0 <= width - 1 && v0 <= height - 1)) return false;

  const float cx = float(centre.x), cy = float(centre.y), cz = float(centre.z);
  const float h0x = float(h0.x), h0y = float(h0.y), h0z = float(h0.z), h1x = float(h1.x), h1y = float(h1.y), h1z = float(h1.z);
  const float last_x = float(width) - 1.001f, last_y = float(height) - 1.001f;
  // Three loops, because compilers vectorise the arithmetic but not the loads between.
  alignas(32) std::array<float, kPatchLanes> fu, fv;
  alignas(32) std::array<int, kPatchLanes> at;
  for (size_t i = 0; i < kPatchLanes; ++i) {
    const float dx = kOffsets.x[i], dy = kOffsets.y[i];
    const float inverse = 1.f / (cz + h0z * dx + h1z * dy);
    float u = (cx + h0x * dx + h1x * dy) * inverse - 0.5f, v = (cy + h0y * dx + h1y * dy) * inverse - 0.5f;
    u = u > 0.f ? u : 0.f;
    v = v > 0.f ? v : 0.f;
    u = u < last_x ? u : last_x;
    v = v < last_y ? v : last_y;
    const int ui = int(u), vi = int(v);
    at[i] = vi * width + ui;
    fu[i] = u - float(ui);
    fv[i] = v - float(vi);
  }
  const float* pixels = other.data().data();
  struct Neighbours {
    float left, right;
  };
  alignas(32) std::array<Neighbours, kPatchLanes> top, bottom;
  for (size_t i = 0; i < kPatchLanes; ++i) {
    std::memcpy(&top[i], pixels + at[i], sizeof(Neighbours));
    std::memcpy(&bottom[i], pixels + at[i] + width, sizeof(Neighbours));
  }
  for (size_t i = 0; i < kPatchLanes; ++i) {
    const float above = top[i].left + fu[i] * (top[i].right - top[i].left);
    const float below = bottom[i].left + fu[i] * (bottom[i].right - bottom[i].left);
    value[i] = above + fv[i] * (below - above);
  }
  return true;
}

}  // namespace

ReferencePatch reference_patch(const ImageF& luma, int x, int y) {
  ReferencePatch patch;
  std::array<float, kPatchLanes>& value = patch.value;
  const float centre = luma.at(x, y);
  float total = 0, mean = 0;
  for (size_t i = 0; i < kPatchPixels; ++i) {
    value[i] = luma.at(std::clamp(x + int(kOffsets.x[i]), 0, luma.width() - 1),
                       std::clamp(y + int(kOffsets.y[i]), 0, luma.height() - 1));
    patch.weight[i] = std::exp(-std::abs(value[i] - centre) / kBrightnessReach);
    total += patch.weight[i];
  }
  for (size_t i = 0; i < kPatchPixels; ++i) {
    patch.weight[i] /= total;
    mean += patch.weight[i] * value[i];
  }
  for (size_t i = 0; i < kPatchPixels; ++i) {
    patch.weighted_value[i] = patch.weight[i] * (value[i] - mean);
    patch.variance += patch.weighted_value[i] * (value[i] - mean);
  }
  return patch;
}

Transfer transfer_between(const View& reference, const View& other) {
  const Rigid relative = other.cam_from_world * inverse(reference.cam_from_world);
  const Intrinsics &k = reference.intrinsics, &ko = other.intrinsics;
  // Columns of R K^-1, then K' from the left.
  const Mat3d& r = relative.rotation;
  const auto by_other = [&](const Vec3d& v) { return Vec3d{ko.fx * v.x + ko.cx * v.z, ko.fy * v.y + ko.cy * v.z, v.z}; };
  Transfer t;
  t.rotation_part = {by_other(r.c0 / k.fx), by_other(r.c1 / k.fy), by_other(r.c2 - (k.cx / k.fx) * r.c0 - (k.cy / k.fy) * r.c1)};
  t.translation_part = by_other(relative.translation);
  t.centre = inverse(relative).translation;
  return t;
}

float patch_score(const ReferencePatch& patch, const ImageF& other, const Transfer& transfer, const Vec3d& plane_by_pixel,
                  double x, double y) {
  alignas(32) std::array<float, kPatchLanes> value;
  if (!carried(other, transfer, plane_by_pixel, x, y, value)) return kUnseenScore;
  const float* w = patch.weight.data();
  const float mean = lane_sum([&](size_t i) { return w[i] * value[i]; });
  const float squares = lane_sum([&](size_t i) { return w[i] * (value[i] - mean) * (value[i] - mean); });
  const float product = lane_sum([&](size_t i) { return patch.weighted_value[i] * value[i]; });
  const float variance = squares * patch.variance;
  if (!(variance > 1e-12f)) return -1;
  return std::clamp(product / std::sqrt(variance), -1.f, 1.f);
}

float patch_difference(const ReferencePatch& patch, const ImageF& other, const Transfer& transfer, const Vec3d& plane_by_pixel,
                       double x, double y) {
  alignas(32) std::array<float, kPatchLanes> value;
  if (!carried(other, transfer, plane_by_pixel, x, y, value)) return kUnseenScore;
  return lane_sum([&](size_t i) { return patch.weight[i] * std::abs(value[i] - patch.value[i]); });
}

}  // namespace vitrine
