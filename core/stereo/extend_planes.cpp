#include "core/stereo/extend_planes.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <utility>

#include "core/stereo/patch_score.h"

namespace vitrine {

namespace {

constexpr double kEdgeCost = 40;      // of a step across a full change of brightness, in pixels
constexpr float kFarHandicap = 0.025f;  // of brightness: by how much the far background must fit better than the plane
constexpr double kLongestBlind = 40;   // path that a plane is followed where no other photo looks
constexpr int kFitRadius = 10;        // pixels around a source that its plane is fitted to
constexpr double kSamePlane = 0.02;   // relative difference of inverse depth up to which a pixel lies on the plane
constexpr double kMostStretched = 4;  // of a source's depth: how far its plane may be followed

// Inverse depth is affine in the pixel on a plane: 1/z = a x + b y + c.
struct InversePlane {
  double a = 0, b = 0, c = 0;
  double at(double x, double y) const { return a * x + b * y + c; }
};

// Least squares over the reliable pixels around (x, y) that lie on the pixel's own plane, then on the fitted one.
InversePlane fitted_plane(const Intrinsics& k, const DepthMap& map, int x, int y) {
  const size_t centre = map.index(x, y);
  const Vec3d n = cast<double>(map.normal[centre]);
  const double offset = double(map.zdepth[centre]) * dot(n, k.ray(x + 0.5, y + 0.5));
  InversePlane plane{n.x / k.fx / offset, n.y / k.fy / offset, (n.z - n.x * k.cx / k.fx - n.y * k.cy / k.fy) / offset};
  for (int round = 0; round < 2; ++round) {
    double count = 0, sx = 0, sy = 0, sw = 0, sxx = 0, sxy = 0, syy = 0, sxw = 0, syw = 0;
    for (int v = std::max(0, y - kFitRadius); v <= std::min(map.height - 1, y + kFitRadius); ++v)
      for (int u = std::max(0, x - kFitRadius); u <= std::min(map.width - 1, x + kFitRadius); ++u) {
        const size_t i = map.index(u, v);
        if (!map.reliable(i)) continue;
        const double w = 1 / double(map.zdepth[i]), expected = plane.at(u + 0.5, v + 0.5);
        if (!(std::abs(w - expected) < kSamePlane * w)) continue;
        const double du = u - x, dv = v - y;
        count += 1, sx += du, sy += dv, sw += w, sxx += du * du, sxy += du * dv, syy += dv * dv, sxw += du * w, syw += dv * w;
      }
    if (count < 12) break;
    const double mx = sx / count, my = sy / count, mw = sw / count;
    const double xx = sxx / count - mx * mx, xy = sxy / count - mx * my, yy = syy / count - my * my;
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 0.05 * xx * yy) || !(xx > 1) || !(yy > 1)) break;  // a strip does not fix a plane
    const double xw = sxw / count - mx * mw, yw = syw / count - my * mw;
    plane.a = (xw * yy - yw * xy) / determinant;
    plane.b = (yw * xx - xw * xy) / determinant;
    plane.c = mw - plane.a * (mx + x + 0.5) - plane.b * (my + y + 0.5);
  }
  return plane;
}

// Mean difference in brightness to the two photos that the plane fits best; 1 where none sees it.
class Explanation {
 public:
  Explanation(std::span<const StereoPhoto> photos, size_t index) : photos_(photos), photo_(photos[index]) {
    for (uint32_t n : photo_.neighbours) transfers_.push_back(transfer_between(photo_.view, photos[n].view));
  }
  float difference(const ReferencePatch& patch, const InversePlane& plane, double x, double y) const {
    float best = 1, second = 1;
    for (size_t i = 0; i < transfers_.size(); ++i) {
      const float d = patch_difference(patch, photos_[photo_.neighbours[i]].luma, transfers_[i], {plane.a, plane.b, plane.c}, x, y);
      if (d < 0) continue;
      if (d < best) second = std::exchange(best, d);
      else if (d < second) second = d;
    }
    return second < 1 ? 0.5f * (best + second) : best;
  }

 private:
  std::span<const StereoPhoto> photos_;
  const StereoPhoto& photo_;
  std::vector<Transfer> transfers_;
};

}  // namespace

void extend_planes(std::span<const StereoPhoto> photos, size_t index, DepthMap& map) {
  const StereoPhoto& photo = photos[index];
  const Intrinsics& k = photo.view.intrinsics;
  const size_t pixels = map.zdepth.size();
  std::vector<double> cost(pixels, 1e300);
  std::vector<uint32_t> source(pixels);
  using Entry = std::pair<double, uint32_t>;  // ties by index: one order on every machine
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (size_t i = 0; i < pixels; ++i)
    if (map.reliable(i)) {
      cost[i] = 0;
      source[i] = uint32_t(i);
      open.emplace(0.0, uint32_t(i));
    }
  if (open.empty()) return;
  while (!open.empty()) {
    const auto [c, i] = open.top();
    open.pop();
    if (c > cost[i]) continue;
    const int x = int(i) % map.width, y = int(i) / map.width;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int u = x + dx, v = y + dy;
      if (u < 0 || v < 0 || u >= map.width || v >= map.height) continue;
      const size_t j = map.index(u, v);
      const double next = c + 1 + kEdgeCost * double(std::abs(photo.luma.at(u, v) - photo.luma.at(x, y)));
      if (!(next < cost[j])) continue;
      cost[j] = next;
      source[j] = source[i];
      open.emplace(next, uint32_t(j));
    }
  }
  std::vector<float> zdepth = map.zdepth;
  std::vector<Vec3f> normal = map.normal;
  std::vector<std::optional<InversePlane>> fitted(pixels);
  const Explanation explanation(photos, index);
  const InversePlane far{0, 0, 1 / photo.far_z};
  for (size_t i = 0; i < pixels; ++i) {
    if (map.reliable(i)) continue;
    const uint32_t from = source[i];
    if (!fitted[from]) fitted[from] = fitted_plane(k, map, int(from) % map.width, int(from) / map.width);
    const InversePlane& plane = *fitted[from];
    const double x = double(int(i) % map.width) + 0.5, y = double(int(i) / map.width) + 0.5;
    const Vec3d ray = k.ray(x, y);
    const double near = double(map.zdepth[from]), w = plane.at(x, y);
    const ReferencePatch patch = reference_patch(photo.luma, int(x), int(y));
    const float near_difference = explanation.difference(patch, plane, x, y);
    if (near_difference >= 1 ? cost[i] > kLongestBlind : explanation.difference(patch, far, x, y) + kFarHandicap < near_difference) {
      zdepth[i] = float(photo.far_z);
      normal[i] = cast<float>(-normalized(ray));
      continue;
    }
    const bool met = w * near < kMostStretched && w * near > 1 / kMostStretched;  // else seen too much along: on at its depth
    zdepth[i] = float(std::clamp(met ? 1 / w : near, photo.near_z, photo.far_z));
    // n/d in the components of the ray: the camera is on the side where it is positive, so the normal towards it is its negative.
    const Vec3d n = -Vec3d{plane.a * k.fx, plane.b * k.fy, plane.c + plane.a * k.cx + plane.b * k.cy};
    normal[i] = met ? cast<float>(normalized(n)) : cast<float>(-normalized(ray));
  }
  map.zdepth = std::move(zdepth);
  map.normal = std::move(normal);
}

}  // namespace vitrine
