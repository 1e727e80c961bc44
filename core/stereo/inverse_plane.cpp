#include "core/stereo/inverse_plane.h"

#include <algorithm>
#include <cmath>

namespace vitrine {

namespace {

constexpr int kFitRadius = 10;       // pixels
constexpr double kSamePlane = 0.02;  // relative difference of inverse depth up to which a pixel lies on the plane

}  // namespace

InversePlane inverse_plane(const Intrinsics& k, const Vec3d& n, double offset) {
  return {n.x / k.fx / offset, n.y / k.fy / offset, (n.z - n.x * k.cx / k.fx - n.y * k.cy / k.fy) / offset};
}

Vec3d normal_towards_camera(const Intrinsics& k, const InversePlane& plane) {
  // n/d in the components of the ray: the camera is on the side where it is positive, so the normal towards it is its negative.
  return -normalized(Vec3d{plane.a * k.fx, plane.b * k.fy, plane.c + plane.a * k.cx + plane.b * k.cy});
}

InversePlane fitted_plane(const Intrinsics& k, const DepthMap& map, int x, int y) {
  const size_t centre = map.index(x, y);
  const Vec3d n = cast<double>(map.normal[centre]);
  InversePlane plane = inverse_plane(k, n, double(map.zdepth[centre]) * dot(n, k.ray(x + 0.5, y + 0.5)));
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

}  // namespace vitrine
