// The cameras of a gallery: as near as possible while every standing piece stays inside every picture.
#include <algorithm>
#include <cmath>

#include "sample_data/generate/scenes/gallery_layout.h"

namespace vitrine::generate {
namespace {

constexpr uint64_t kViewPurpose = 4, kSwayPurpose = 5;
constexpr double kMargin = 0.02;  // of the picture that stays free at each edge

// Points on the cylinders around the pieces.
std::vector<Vec3d> outline_points(const GalleryPlan& plan) {
  std::vector<Vec3d> points;
  for (const PlacedPiece& placed : plan.pieces) {
    if (placed.piece.hangs) continue;
    for (int i = 0; i < 12; ++i) {
      const double phi = 2 * std::numbers::pi * i / 12, r = static_cast<double>(placed.radius);
      for (const double z : {0.0, static_cast<double>(placed.height)})
        points.push_back(cast<double>(placed.centre) +
                         Vec3d{r * std::cos(phi), r * std::sin(phi), z - static_cast<double>(placed.centre.z)});
    }
  }
  return points;
}

bool all_inside(const std::vector<Vec3d>& points, const Rigid& cam_from_world, const Intrinsics& k) {
  return std::all_of(points.begin(), points.end(), [&](const Vec3d& point) {
    const Vec3d p = cam_from_world * point;
    const double u = (k.fx * p.x / p.z + k.cx) / k.width, v = (k.fy * p.y / p.z + k.cy) / k.height;
    return p.z > 0.1 && u > kMargin && u < 1 - kMargin && v > kMargin && v < 1 - kMargin;
  });
}

// Distance of a ring, metres.
double nearest_distance(const std::vector<Vec3d>& points, const CameraRing& ring, const Vec3d& target, const Intrinsics& k) {
  constexpr double kFarthest = 2.2;
  for (double distance = 0.6; distance < kFarthest; distance *= 1.02) {
    bool fits = true;
    for (int i = 0; i < 24 && fits; ++i) {
      const double azimuth = ring.azimuth_rad + ring.span_rad * i / 24;
      const Vec3d out{std::cos(ring.elevation_rad) * std::cos(azimuth), std::cos(ring.elevation_rad) * std::sin(azimuth),
                      std::sin(ring.elevation_rad)};
      fits = all_inside(points, looking_at(target + distance * out, target, {0, 0, 1}), k);
    }
    if (fits) return distance;
  }
  return kFarthest;
}

}  // namespace

void add_gallery_views(Scene& scene, const GalleryPlan& plan, uint64_t seed) {
  Draw draw(seed, kViewPurpose);
  const double focal = static_cast<double>(draw.between(285, 330));
  const Intrinsics camera{
      320, 240, focal, focal, 160 + static_cast<double>(draw.between(-4, 4)), 120 + static_cast<double>(draw.between(-4, 4))};
  const std::vector<Vec3d> points = outline_points(plan);
  const double tall = static_cast<double>(plan.height);
  const int rings = draw.whole(1, 3), total = draw.whole(24, 48);
  for (int i = 0; i < rings; ++i) {
    // From low to high; a single ring stays in the middle.
    const float level = rings == 1 ? 0.5f : static_cast<float>(i) / static_cast<float>(rings - 1);
    CameraRing ring{.count = total / rings + (i < total % rings ? 1 : 0),
                    .azimuth_rad = static_cast<double>(draw.between(0, 2 * kPi)),
                    .elevation_rad = static_cast<double>(0.26f + 0.52f * level + draw.between(-0.06f, 0.06f)),
                    .sway = static_cast<double>(draw.between(0.03f, 0.06f)),
                    .seed = mix64(seed, kSwayPurpose)};
    if (plan.wall_y) {
      ring.span_rad = static_cast<double>(draw.between(2.3f, 2.7f));
      ring.azimuth_rad = -0.5 * std::numbers::pi - 0.5 * ring.span_rad * (1 - 1.0 / ring.count);
    }
    // The aim that lets the cameras come nearest.
    Vec3d target{};
    ring.distance = 1e9;
    for (const double share : {0.15, 0.25, 0.35, 0.45, 0.55}) {
      const Vec3d aim{0, plan.wall_y ? 0.04 : 0.0, share * tall};
      const double distance = nearest_distance(points, ring, aim, camera);
      if (distance < ring.distance) target = aim;
      ring.distance = std::min(ring.distance, distance);
    }
    ring.distance *= 1 + 0.5 * ring.sway;
    add_ring(scene, ring, target, camera);
  }
}

}  // namespace vitrine::generate
