// Ellipsoids of constant density: their line integrals are chords, exact for any ray.
#pragma once

#include <numbers>
#include <vector>

#include "core/foundation/base/rng.h"
#include "core/scene/image/image.h"
#include "stages/tomography/scan_geometry.h"

namespace vitrine::test {

struct Ellipsoid {
  Vec3d half_axes, centre;
  double turn_deg;  // about z
  double density;   // added to what is there
};
using Phantom = std::vector<Ellipsoid>;

// In the frame where the ellipsoid is the unit ball.
inline Vec3d in_ball(const Ellipsoid& e, const Vec3d& v) {
  const double a = e.turn_deg * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a);
  return {(c * v.x + s * v.y) / e.half_axes.x, (c * v.y - s * v.x) / e.half_axes.y, v.z / e.half_axes.z};
}

inline double density(const Phantom& phantom, const Vec3d& p) {
  double sum = 0;
  for (const Ellipsoid& e : phantom)
    if (squared_length(in_ball(e, p - e.centre)) <= 1) sum += e.density;
  return sum;
}

inline double line_integral(const Phantom& phantom, const VolumeRay& ray) {
  double sum = 0;
  for (const Ellipsoid& e : phantom) {
    const Vec3d o = in_ball(e, ray.origin - e.centre), u = in_ball(e, ray.direction);
    const double uu = squared_length(u), ou = dot(o, u), inside = ou * ou - uu * (squared_length(o) - 1);
    if (inside > 0) sum += e.density * 2 * std::sqrt(inside) / uu;
  }
  return sum;
}

// Shepp and Logan's head (1974) in three dimensions, with Toft's (1996) contrast.
inline Phantom head() {
  return {{{.69, .92, .81}, {0, 0, 0}, 0, 1},        {{.6624, .874, .78}, {0, -.0184, 0}, 0, -.8},
          {{.11, .31, .22}, {.22, 0, 0}, -18, -.2},  {{.16, .41, .28}, {-.22, 0, 0}, 18, -.2},
          {{.21, .25, .41}, {0, .35, -.15}, 0, .1},  {{.046, .046, .05}, {0, .1, .25}, 0, .1},
          {{.046, .046, .05}, {0, -.1, .25}, 0, .1}, {{.046, .023, .05}, {-.08, -.605, 0}, 0, .1},
          {{.023, .023, .02}, {0, -.606, 0}, 0, .1}, {{.023, .046, .02}, {.06, -.605, 0}, 0, .1}};
}

// A jar with a lid: a shell, and dense and light things in it.
inline Phantom closed_jar() {
  return {{{.8, .8, .9}, {0, 0, 0}, 0, .6},        {{.72, .72, .82}, {0, 0, 0}, 0, -.58},
          {{.3, .12, .1}, {.2, .1, -.4}, 25, 1},   {{.1, .1, .35}, {-.3, -.2, -.1}, 0, .5},
          {{.14, .14, .14}, {-.1, .4, .1}, 0, .8}, {{.25, .06, .2}, {.1, -.4, .2}, 60, .4}};
}

// Cone beam around an object of about [-1, 1]^3, which the picture just contains.
inline ScanGeometry cone_scan(int views, int pixels) {
  ScanGeometry g;
  g.beam = Beam::Cone, g.source_distance = 6, g.detector_distance = 9, g.pixel_size = 3.3 / pixels;
  g.width = g.height = pixels;
  for (int i = 0; i < views; ++i) g.angles.push_back(2 * std::numbers::pi * i / views);
  return g;
}
inline ScanGeometry parallel_scan(int views, int pixels) {
  ScanGeometry g;
  g.pixel_size = 2.2 / pixels;
  g.width = g.height = pixels;
  for (int i = 0; i < views; ++i) g.angles.push_back(std::numbers::pi * i / views);
  return g;
}

// Means of 2 x 2 rays a pixel.
inline std::vector<ImageF> scanned(const ScanGeometry& g, const Phantom& phantom) {
  ScanGeometry fine = g;
  fine.width *= 2, fine.height *= 2, fine.pixel_size /= 2;
  std::vector<ImageF> out;
  for (const double angle : g.angles) {
    const std::vector<VolumeRay> rays = scan_rays(fine, angle);
    ImageF& image = out.emplace_back(g.width, g.height, 1);
    for (size_t i = 0; i < rays.size(); ++i) {
      const int x = int(i % size_t(fine.width)) / 2, y = int(i / size_t(fine.width)) / 2;
      image.at(x, y) += float(0.25 * line_integral(phantom, rays[i]));
    }
  }
  return out;
}

// As a detector sees them that counts `photons` where nothing absorbs, normal noise for Poisson's; 0: without noise.
inline std::vector<ImageF> counted(std::vector<ImageF> projections, double photons) {
  Rng rng(11, 5);
  for (ImageF& image : projections)
    for (float& v : image.data()) {
      if (!(photons > 0)) continue;
      const double expected = photons * std::exp(-double(v)), count = expected + std::sqrt(expected) * double(rng.normal());
      v = float(-std::log(std::max(count, 0.5) / photons));
    }
  return projections;
}

// Means of 3^3 points a cell.
inline VoxelGrid<float> truth(const Phantom& phantom, VoxelGrid<float> grid) {
  grid.values.assign(grid.count(), 0.f);
  grid.each_in_order([&](int x, int y, int z) {
    double sum = 0;
    for (int k = 0; k < 27; ++k)
      sum += density(phantom,
                     grid.centre(x, y, z) + grid.cell / 3 * Vec3d{double(k % 3 - 1), double(k / 3 % 3 - 1), double(k / 9 - 1)});
    grid.values[grid.index(x, y, z)] = float(sum / 27);
  });
  return grid;
}

// Peak signal-to-noise ratio over all cells; the peak is the largest true value.
inline double psnr(const VoxelGrid<float>& volume, const VoxelGrid<float>& expected) {
  double sum = 0, peak = 0;
  for (size_t i = 0; i < expected.count(); ++i) {
    const double d = double(volume.values[i]) - double(expected.values[i]);
    sum += d * d, peak = std::max(peak, double(expected.values[i]));
  }
  return 10 * std::log10(peak * peak * double(expected.count()) / sum);
}

}  // namespace vitrine::test
