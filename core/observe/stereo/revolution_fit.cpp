#include "core/observe/stereo/revolution_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/connected_components.h"
#include "core/foundation/math/quantile.h"
#include "core/foundation/math/vec.h"
#include "core/scene/camera/projection.h"

namespace vitrine {

namespace {

constexpr int kHeights = 48;            // of the profile
constexpr int kMarch = 32, kHalve = 7;  // coarse radii tried inwards, then bisections
constexpr double kAgainst = 0.12;       // quantile of the contour ends for the initial radius: tolerates occluders
constexpr size_t kFewestPhotos = 3, kFewestEnds = 8;
constexpr double kFirstMove = 0.06, kLastMove = 5e-4;  // of the bounds' diagonal; radians for the tilt
constexpr int kRounds = 4;                             // alternating fits of contours and radii, for one axis
constexpr int kSmoothing = 4;                          // passes of the filter 1 2 1 over the profile
constexpr double kOutlier = 0.15;                      // of the largest radius: beyond it a handle or another appendage
constexpr double kOn = 2, kOnIt = 0.6;  // voxels: distance to the solid; share of a hull component that must lie within it
constexpr double kTouching = 1.8;       // voxels: maximum gap between connected points of a component
constexpr size_t kSmallestPiece = 20, kFewestPoints = 200;  // of the surface: one part in; points

using Profile = std::array<double, kHeights>;  // radii; 0 = none

// Fits discs around an axis to the silhouettes.
class Rims {
 public:
  Rims(std::span<const Silhouette> masks, const Bounds3& about) : masks_(masks) {
    const Vec3d size = about.high - about.low;
    reach_ = 0.75 * std::hypot(size.x, size.y), half_height_ = 0.6 * size.z;
  }
  double height(size_t i) const { return half_height_ * (2.0 * double(i) / (kHeights - 1) - 1); }
  double step() const { return 2 * half_height_ / (kHeights - 1); }

  // Initial radii: for each height the widest disc whose left and right ends lie in the masks.
  Profile widest(const TurningAxis& axis) const {
    Profile radii{};
    parallel_for(kHeights, 2, [&](size_t i) {
      const Disc disc{axis.origin + height(i) * axis.along, axis.u, axis.v};
      std::vector<double> ends;
      for (const Silhouette& m : masks_) {
        const double towards = azimuth(m, disc);
        for (double side : {-0.5, 0.5})
          if (const auto r = silhouette(m, disc, towards + side * std::numbers::pi, 0.98 * reach_)) ends.push_back(*r);
      }
      radii[i] = ends.size() < kFewestEnds ? 0 : quantile_of(ends, kAgainst);
    });
    return radii;
  }

  // Moves the radii of `profile` to the median silhouette edge. The contour of a disc's rim is where the line of sight touches
  // the surface. Returns the mean distance between the silhouettes and the solid.
  double fit(const TurningAxis& axis, Profile& profile) const {
    double mean = 0;
    for (int round = 0; round < kRounds; ++round) {
      const Profile now = smooth(profile);
      const double outlier = kOutlier * *std::ranges::max_element(now);
      std::array<double, kHeights> error{}, count{};
      parallel_for(kHeights, 2, [&](size_t i) {
        if (!(now[i] > 0)) return;
        const bool first = i == 0 || !(now[i - 1] > 0), last = i + 1 == kHeights || !(now[i + 1] > 0);
        const double slope = (now[last ? i : i + 1] - now[first ? i : i - 1]) / (step() * (first || last ? 1 : 2));
        const Disc disc{axis.origin + height(i) * axis.along, axis.u, axis.v};
        std::vector<double> ends;
        for (const Silhouette& m : masks_) {
          const Vec3d to_camera = m.view.centre_in_world() - disc.centre;
          const double distance = std::hypot(dot(to_camera, axis.u), dot(to_camera, axis.v));
          const double cosine = (now[i] + slope * dot(to_camera, axis.along)) / distance;
          if (!(std::abs(cosine) < kTouch)) continue;
          for (double side : {-1.0, 1.0})
            if (const auto r = silhouette(m, disc, azimuth(m, disc) + side * std::acos(cosine), now[i])) ends.push_back(*r);
        }
        if (ends.size() < kFewestEnds) return;
        const double seen = quantile_of(ends, 0.5);
        for (double r : ends) error[i] += std::min(std::abs(r - seen), outlier);
        profile[i] = 0.5 * (now[i] + seen);
        count[i] = double(ends.size());
      });
      double errors = 0, counts = 0;
      for (size_t i = 0; i < kHeights; ++i) errors += error[i], counts += count[i];
      mean = counts > 0 ? errors / counts : 1e300;
    }
    return mean;
  }

  static Profile smooth(Profile radii) {
    for (int pass = 0; pass < kSmoothing; ++pass) {
      const Profile before = radii;
      for (size_t i = 1; i + 1 < kHeights; ++i)
        if (before[i - 1] > 0 && before[i] > 0 && before[i + 1] > 0)
          radii[i] = (before[i - 1] + 2 * before[i] + before[i + 1]) / 4;
    }
    return radii;
  }

 private:
  static constexpr double kTouch = 0.98;  // maximum |cosine|: seen nearly from above the rim is no contour
  struct Disc {
    Vec3d centre, u, v;
  };
  static double azimuth(const Silhouette& m, const Disc& disc) {
    const Vec3d to_camera = m.view.centre_in_world() - disc.centre;
    return std::atan2(dot(to_camera, disc.v), dot(to_camera, disc.u));
  }

  // Coverage of the silhouette at the radius r in one direction.
  static float coverage(const Silhouette& m, const Disc& disc, const Vec3d& direction, double r) {
    const auto p = projection(disc.centre + r * direction, m.view, 1e-6);
    return p ? coverage_at(m.value, p->x, p->y) : -1;
  }

  // The radius in that direction where the mask ends, the nearest to `from`; nullopt where the mask is unknown.
  std::optional<double> silhouette(const Silhouette& m, const Disc& disc, double angle, double from) const {
    const Vec3d direction = std::cos(angle) * disc.u + std::sin(angle) * disc.v;
    const double step = reach_ / kMarch;
    const float at_from = coverage(m, disc, direction, from);
    if (at_from < 0) return std::nullopt;
    const bool inside = at_from >= 0.5f;
    double good = inside ? from : 0, bad = inside ? reach_ : from;
    for (double r = from;;) {
      r += inside ? step : -step;
      if (r >= reach_) return reach_;
      if (r <= 0) return 0;
      const float here = coverage(m, disc, direction, r);
      if (here < 0) return std::nullopt;
      if ((here >= 0.5f) == inside) {
        (inside ? good : bad) = r;
        continue;
      }
      (inside ? bad : good) = r;
      break;
    }
    for (int j = 0; j < kHalve; ++j) {
      const double middle = 0.5 * (good + bad);
      (coverage(m, disc, direction, middle) >= 0.5f ? good : bad) = middle;
    }
    return good;
  }

  std::span<const Silhouette> masks_;
  double reach_, half_height_;
};

double volume(const Profile& radii) {
  double sum = 0;
  for (double r : radii) sum += r * r;
  return sum;
}

std::optional<SurfaceOfRevolution> surface_for(std::span<const Silhouette> masks, const Bounds3& about) {
  const Rims rims(masks, about);
  const double size = length(about.high - about.low);
  AxisPlace place{about.centre().x, about.centre().y, 0, 0};
  const auto axis = [&](const AxisPlace& p) { return turning_axis({p[0], p[1], about.centre().z}, p[2], p[3]); };
  improve_axis(
      size, kFirstMove, kLastMove, 2, [&](const AxisPlace& p) { return volume(rims.widest(axis(p))); }, place);
  Profile profile = rims.widest(axis(place));
  rims.fit(axis(place), profile);
  improve_axis(
      size, kFirstMove / 2, kLastMove, 4,
      [&](const AxisPlace& p) {
        Profile trial = profile;
        return -rims.fit(axis(p), trial);
      },
      place);
  for (int i = 0; i < kRounds; ++i) rims.fit(axis(place), profile);
  profile = Rims::smooth(profile);
  // The longest run of heights with a disc.
  size_t first = 0, count = 0;
  for (size_t i = 0, run = 0; i < profile.size(); ++i) {
    run = profile[i] > 0 ? run + 1 : 0;
    if (run > count) count = run, first = i + 1 - run;
  }
  if (count < 4) return std::nullopt;
  const TurningAxis a = axis(place);
  return revolved(a.origin, a.along, rims.height(first), rims.step(), std::span(profile).subspan(first, count));
}

// Point indices of each connected component of a surface with more than `least` points; points are one voxel apart.
std::vector<std::vector<size_t>> pieces(std::span<const ShapePoint> surface, double voxel, size_t least) {
  std::map<CellIndex, std::vector<size_t>> points;
  for (size_t i = 0; i < surface.size(); ++i) {
    const Vec3d q = surface[i].position / (kTouching * voxel);
    points[{int(std::floor(q.x)), int(std::floor(q.y)), int(std::floor(q.z))}].push_back(i);
  }
  std::vector<CellIndex> cells;
  for (const auto& [cell, in_cell] : points) cells.push_back(cell);
  std::vector<std::vector<size_t>> found;
  for (const auto& members : connected_cells(cells).members) {
    std::vector<size_t> piece;
    for (size_t i : members) piece.insert(piece.end(), points[cells[i]].begin(), points[cells[i]].end());
    if (piece.size() >= least) found.push_back(std::move(piece));
  }
  return found;
}

}  // namespace

SurfaceOfRevolution revolved(const Vec3d& origin, const Vec3d& axis, double low, double step, std::span<const double> radii) {
  SurfaceOfRevolution out{origin, axis, {{0, low}}};
  for (size_t i = 0; i < radii.size(); ++i) out.profile.push_back({radii[i], low + step * double(i)});
  out.profile.push_back({0, low + step * double(radii.size() - 1)});
  return out;
}

std::vector<uint8_t> silhouette_mask(const SurfaceOfRevolution& surface, const View& view) {
  return mask_of_rays(view, [&](size_t, const Vec3d& eye, const Vec3d& direction) {
    return surface.intersect({eye, direction}).has_value();
  });
}

std::vector<SurfaceOfRevolution> surfaces_of_revolution(std::span<const Silhouette> masks, std::span<const ShapePoint> surface,
                                                        double voxel) {
  std::vector<SurfaceOfRevolution> found;
  if (masks.size() < kFewestPhotos) return found;
  for (const std::vector<size_t>& piece : pieces(surface, voxel, std::max(kFewestPoints, surface.size() / kSmallestPiece))) {
    Bounds3 bounds;
    for (size_t i : piece) bounds.extend(surface[i].position);
    const auto solid = surface_for(masks, bounds);
    if (!solid) continue;
    size_t on = 0;
    for (size_t i : piece) on += length(solid->nearest(surface[i].position).position - surface[i].position) <= kOn * voxel;
    if (double(on) >= kOnIt * double(piece.size())) found.push_back(*solid);
  }
  return found;
}

}  // namespace vitrine
