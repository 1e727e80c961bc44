// Ways of the transmittance between overlapping Gaussians, compared on the same scenes: PSNR and mean absolute error of colour
// against quadrature on rays of a few tiles (truth: reference_emission), and CPU time of the picture. Fast ways are in float, a
// tile at a time; those whose name ends in "double" show accuracy alone.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/render/volume/emission_absorption.h"
#include "core/render/volume/reference/reference.h"
#include "core/render/volume/tile_sums.h"

namespace vitrine {
namespace {

constexpr int kWaySide = 96;
constexpr size_t kWayRays = RayTiles::kRays;

struct WayScene {
  std::vector<Gaussian3d> exact;
  std::vector<Gaussian3f> gaussians;
  std::vector<Vec3f> colors;
  std::vector<Vec3d> exact_colors;
  std::vector<VolumeRay> rays;
  std::vector<size_t> checked;  // pixels with truth
  std::vector<VolumeLightd> truth;
};

std::vector<Gaussian3d> random_cloud(size_t count, double log_scale, double log_density, uint64_t seed) {
  std::vector<Gaussian3d> out(count);
  for (size_t i = 0; i < count; ++i) {
    Rng rng(seed, i);
    const auto normal = [&] { return double(rng.normal()); };
    Gaussian3d& g = out[i];
    g.mean = 0.4 * Vec3d{normal(), normal(), normal()};
    for (size_t c = 0; c < 3; ++c) g.log_scale[c] = log_scale + 0.5 * normal();
    g.rotation = {1.3 * normal(), normal(), normal(), normal()};
    g.log_density = log_density + 0.5 * normal();
  }
  return out;
}

// Disks across the rays, one behind the other, that do not overlap.
std::vector<Gaussian3d> slabs(size_t count) {
  std::vector<Gaussian3d> out(count);
  for (size_t i = 0; i < count; ++i) {
    const double k = double(i);
    out[i] = {{0.3 * std::sin(2.1 * k), 0.3 * std::cos(3.3 * k), -0.8 + 1.6 * k / double(count)},
              {std::log(0.4), std::log(0.4), std::log(0.01)},
              {1, 0, 0, 0},
              std::log(15.)};
  }
  return out;
}

const WayScene& way_scene(const std::string& name) {
  static std::map<std::string, WayScene> scenes;
  WayScene& s = scenes[name];
  if (!s.rays.empty()) return s;
  if (name == "cloud_thin") s.exact = random_cloud(150, -2.2, -0.5, 1);
  if (name == "cloud_dense") s.exact = random_cloud(150, -2.2, 2.5, 2);
  if (name == "many_small") s.exact = random_cloud(1500, -2.9, 2.2, 5);
  if (name == "few_large") s.exact = random_cloud(12, -0.9, 0.8, 3);
  if (name == "slabs") s.exact = slabs(40);
  if (name == "two_slabs") s.exact = slabs(2);
  for (size_t i = 0; i < s.exact.size(); ++i) {
    s.gaussians.push_back(cast<float>(s.exact[i]));
    s.exact[i] = cast<double>(s.gaussians[i]);
    Rng rng(77, i);
    s.colors.push_back({rng.uniform(), rng.uniform(), rng.uniform()});
    s.exact_colors.push_back(cast<double>(s.colors[i]));
  }
  for (int y = 0; y < kWaySide; ++y)
    for (int x = 0; x < kWaySide; ++x) {
      const double u = ((x + 0.5) / kWaySide - 0.5) * 2.4, v = ((y + 0.5) / kWaySide - 0.5) * 2.4;
      s.rays.push_back({{0, 0, -4}, normalized(Vec3d{u, v, 4})});
    }
  for (size_t i = 0; i < s.rays.size(); i += 53) {
    const size_t x = i % kWaySide, y = i / kWaySide;
    if (4 * x > kWaySide && 4 * x < 3 * kWaySide && 4 * y > kWaySide && 4 * y < 3 * kWaySide) s.checked.push_back(i);
  }
  std::vector<VolumeRay> some;
  for (const size_t i : s.checked) some.push_back(s.rays[i]);
  s.truth = reference_emission({s.exact, s.exact_colors}, some);
  return s;
}

struct TileProfiles {
  alignas(64) TileValues depth, at, width;
  Vec3f color;
  float mean_at;
};

TileProfiles profile_in_tile(const LineIntegrals::Prepared& g, const RayTiles::Tile& tile) {
  alignas(64) TileValues depth, at, width;
  for (size_t i = 0; i < kWayRays; ++i) {
    const Vec3f direction = g.matrix * Vec3f{tile.direction[0][i], tile.direction[1][i], tile.direction[2][i]};
    const Vec3f o = g.matrix * (Vec3f{tile.origin[0][i], tile.origin[1][i], tile.origin[2][i]} - g.mean);
    const float inverse = 1.f / squared_length(direction);
    at[i] = -dot(o, direction) * inverse;
    width[i] = std::sqrt(inverse);
    depth[i] = g.peak * width[i] * exponential<-50>(-0.5f * squared_length(o + at[i] * direction));
  }
  return {depth, at, width, {}, sum_of_products(depth, at) / sum_of(depth)};
}

std::vector<TileProfiles> profiles_of_tile(const WayScene& s, const LineIntegrals& lines, size_t t) {
  std::vector<TileProfiles> out;
  out.reserve(lines.instances_of_tile(t).size());
  for (const uint32_t instance : lines.instances_of_tile(t)) {
    const uint32_t g = lines.gaussian_of(instance);
    out.push_back(profile_in_tile(lines.prepared_at(g), lines.rays().tiles()[t]));
    out.back().color = s.colors[g];
  }
  return out;
}

struct TileColors {
  alignas(64) TileValues c[3] = {};
};

// Front to back in the order of their mean distances in the tile, each as if it ended before the next begins.
TileColors sorted_way(std::vector<TileProfiles>& profiles) {
  std::vector<const TileProfiles*> order;
  for (const TileProfiles& p : profiles) order.push_back(&p);
  std::sort(order.begin(), order.end(), [](auto* a, auto* b) { return a->mean_at < b->mean_at; });
  TileColors out;
  alignas(64) TileValues transmittance, weight;
  transmittance.fill(1.f);
  for (const TileProfiles* p : order) {
    for (size_t i = 0; i < kWayRays; ++i) {
      const float e = exponential<-50>(-p->depth[i]);
      weight[i] = transmittance[i] * (1.f - e);
      transmittance[i] *= e;
    }
    for (size_t c = 0; c < 3; ++c)
      for (size_t i = 0; i < kWayRays; ++i) out.c[c][i] += weight[i] * p->color[c];
  }
  return out;
}

// Share of the optical depth before z from four power moments (Muenstermann et al. 2018, Peters and Klein 2015): the mean of the
// two bounds of the Hamburger problem. With the Hankel matrix H of the moments, the roots of (1, x, x^2) H^-1 (1, z, z^2)^T are
// the other two points of the distribution of three points with these moments; a quadratic through 0, 1/2, 1 at the points is
// integrated.
struct Hankel {
  alignas(64) TileValues l10, l20, l21, d1, d2;
};
void set_hankel(size_t i, const std::array<float, 5>& b, Hankel& h) {
  const float d1 = b[2] - b[1] * b[1], l21 = (b[3] - b[1] * b[2]) / d1;
  h.l10[i] = b[1], h.l20[i] = b[2], h.l21[i] = l21, h.d1[i] = d1, h.d2[i] = b[4] - b[2] * b[2] - l21 * l21 * d1;
}
// 1 where the difference is negative, by its sign bit.
inline __attribute__((always_inline)) float is_negative(float x) { return float(std::bit_cast<uint32_t>(x) >> 31); }
inline __attribute__((always_inline)) float clamped_to_one(float v) {
  const float low = std::bit_cast<float>(std::max(std::bit_cast<int32_t>(v), 0));
  return std::bit_cast<float>(std::min(std::bit_cast<int32_t>(low), std::bit_cast<int32_t>(1.f)));
}
inline __attribute__((always_inline)) float share_before(const Hankel& h, size_t i, float z) {
  float c1 = z - h.l10[i], c2 = z * z - h.l20[i] - h.l21[i] * c1;
  c2 /= h.d2[i];
  c1 = c1 / h.d1[i] - h.l21[i] * c2;
  const float c0 = 1 - h.l10[i] * c1 - h.l20[i] * c2, p = c1 / c2, q = c0 / c2;
  const float d = std::sqrt(std::fabs(0.25f * p * p - q)), x1 = -0.5f * p - d, x2 = -0.5f * p + d;
  const float f1 = is_negative(x1 - z), f2 = is_negative(x2 - z);
  const float a10 = (f1 - 0.5f) / (x1 - z), a21 = (f2 - f1) / (x2 - x1), a2 = (a21 - a10) / (x2 - z);
  return clamped_to_one(0.5f + a10 * (h.l10[i] - z) + a2 * (h.l20[i] - (z + x1) * h.l10[i] + z * x1));
}

// Each Gaussian is shaded by the mean transmittance at three of its quantiles; the sum is scaled to the exact opacity.
TileColors moments_way(const std::vector<TileProfiles>& profiles) {
  float low = 1e30f, high = -1e30f;
  for (const TileProfiles& p : profiles) {
    low = std::min(low, p.mean_at - 2.5f * p.width[36]);
    high = std::max(high, p.mean_at + 2.5f * p.width[36]);
  }
  TileColors out;
  if (profiles.empty()) return out;
  const float middle = 0.5f * (low + high), scale = 2.f / (high - low);
  alignas(64) TileValues moments[5] = {};
  for (const TileProfiles& p : profiles)
    for (size_t i = 0; i < kWayRays; ++i) {
      const float m = (p.at[i] - middle) * scale, v = p.width[i] * scale * p.width[i] * scale, d = p.depth[i];
      moments[0][i] += d, moments[1][i] += d * m, moments[2][i] += d * (m * m + v), moments[3][i] += d * m * (m * m + 3 * v);
      moments[4][i] += d * (m * m * m * m + 6 * m * m * v + 3 * v * v);
    }
  Hankel matrices;
  constexpr float kBias[5] = {1, 0, 0.375f, 0, 0.375f};  // keeps the matrix definite
  for (size_t i = 0; i < kWayRays; ++i) {
    std::array<float, 5> b;
    for (size_t k = 0; k < 5; ++k) b[k] = (1 - 5e-6f) * moments[k][i] / moments[0][i] + 5e-6f * kBias[k];
    set_hankel(i, b, matrices);
  }
  alignas(64) TileValues weights{}, weight;
  for (const TileProfiles& p : profiles) {
    weight.fill(0.f);
    for (const auto& [x, part] : {std::pair{-1.2120f, 5.f / 18}, {0.f, 8.f / 18}, {1.2120f, 5.f / 18}})
      for (size_t i = 0; i < kWayRays; ++i) {
        const float z = (p.at[i] + x * p.width[i] - middle) * scale;
        weight[i] += part * p.depth[i] * exponential<-50>(-moments[0][i] * share_before(matrices, i, z));
      }
    for (size_t i = 0; i < kWayRays; ++i) weights[i] += weight[i];
    for (size_t c = 0; c < 3; ++c)
      for (size_t i = 0; i < kWayRays; ++i) out.c[c][i] += weight[i] * p.color[c];
  }
  for (size_t i = 0; i < kWayRays; ++i)
    for (size_t c = 0; c < 3; ++c) out.c[c][i] *= (1.f - exponential<-50>(-moments[0][i])) / std::max(weights[i], 1e-20f);
  return out;
}

using OneRay = std::vector<std::pair<RayProfile<double>, Vec3d>>;

double quantile(double u) {
  double low = -9, high = 9;
  for (int i = 0; i < 50; ++i) (normal_cdf(0.5 * (low + high)) < u ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

Vec3d sorted_by_ray(OneRay ray) {
  std::sort(ray.begin(), ray.end(), [](auto& a, auto& b) { return a.first.at < b.first.at; });
  VolumeLightd light{{}, 1};
  for (const auto& [p, color] : ray) {
    light.color += (light.transmittance * -std::expm1(-p.depth)) * color;
    light.transmittance *= std::exp(-p.depth);
  }
  return light.color;
}

// Optical depth of the others in closed form at three points of each Gaussian that see equal parts of its own light.
Vec3d pairs_of_ray(const OneRay& ray) {
  Vec3d sum{};
  for (size_t i = 0; i < ray.size(); ++i) {
    const RayProfile<double>& p = ray[i].first;
    const double alpha = -std::expm1(-p.depth);
    if (alpha < 1e-12) continue;
    for (const auto& [v, part] : {std::pair{0.1127016654, 5. / 18}, {0.5, 8. / 18}, {0.8872983346, 5. / 18}}) {
      const double t = p.at + p.width * quantile(-std::log1p(-alpha * v) / p.depth);
      double depth = 0;
      for (size_t j = 0; j < ray.size(); ++j)
        if (j != i) depth += ray[j].first.depth * normal_cdf((t - ray[j].first.at) / ray[j].first.width);
      sum += (part * alpha * std::exp(-depth)) * ray[i].second;
    }
  }
  return sum;
}

enum class Way { Cells8, Cells16, Cells32, Sorted, Moments, SortedByRay, Pairs };

void picture(const WayScene& s, const EmissionAbsorption& cells, const LineIntegrals& lines, Way way,
             std::vector<VolumeLightf>& light) {
  if (way <= Way::Cells32) return cells.forward(s.colors, light);
  if (way >= Way::SortedByRay) {
    for (const size_t pixel : s.checked) {
      OneRay ray;
      for (size_t i = 0; i < s.exact.size(); ++i) {
        const Whitened<double> w = whitened(s.exact[i]);
        ray.push_back({ray_profile(w, whitened_line(w, s.exact[i].mean, s.rays[pixel].origin, s.rays[pixel].direction)),
                       s.exact_colors[i]});
      }
      std::erase_if(ray, [](auto& p) { return p.first.depth < 1e-12; });
      light[pixel].color = cast<float>(way == Way::Pairs ? pairs_of_ray(ray) : sorted_by_ray(ray));
    }
    return;
  }
  for (size_t t = 0; t < lines.rays().tiles().size(); ++t) {
    std::vector<TileProfiles> profiles = profiles_of_tile(s, lines, t);
    const TileColors colors = way == Way::Sorted ? sorted_way(profiles) : moments_way(profiles);
    const RayTiles::Tile& tile = lines.rays().tiles()[t];
    for (size_t i = 0; i < kWayRays; ++i)
      light[(size_t(tile.y) + i / 8) * kWaySide + size_t(tile.x) + i % 8].color = {colors.c[0][i], colors.c[1][i],
                                                                                   colors.c[2][i]};
  }
}

void way_row(benchmark::State& state, const std::string& name, Way way) {
  const WayScene& s = way_scene(name);
  set_thread_limit(1);
  const RayTiles tiles(s.rays, kWaySide, {});
  const int count = way == Way::Cells8 ? 8 : way == Way::Cells16 ? 16 : 32;
  const EmissionAbsorption cells(tiles, s.gaussians, count);
  const LineIntegrals lines(tiles, s.gaussians);
  std::vector<VolumeLightf> light(s.rays.size());
  for (auto _ : state) picture(s, cells, lines, way, light);
  set_thread_limit(0);
  double squares = 0, sum = 0;
  for (size_t i = 0; i < s.checked.size(); ++i) {
    const Vec3d e = cast<double>(light[s.checked[i]].color) - s.truth[i].color;
    squares += squared_length(e) / 3;
    sum += (std::abs(e.x) + std::abs(e.y) + std::abs(e.z)) / 3;
  }
  state.counters["PSNR"] = -10 * std::log10(squares / double(s.checked.size()));
  state.counters["mean"] = sum / double(s.checked.size());
  state.counters["pairs/ray"] = double(lines.instances()) * double(kWayRays) / double(s.rays.size());
  if (way < Way::SortedByRay)
    state.counters["rays/s/core"] =
        benchmark::Counter(double(s.rays.size()) * double(state.iterations()), benchmark::Counter::kIsRate);
}

const bool ways_registered = [] {
  const std::pair<const char*, Way> ways[] = {{"cells_8", Way::Cells8},    {"cells_16", Way::Cells16},
                                              {"cells_32", Way::Cells32},  {"sorted", Way::Sorted},
                                              {"moments", Way::Moments},   {"sorted_by_ray_double", Way::SortedByRay},
                                              {"pairs_double", Way::Pairs}};
  for (const char* scene : {"cloud_thin", "cloud_dense", "many_small", "few_large", "slabs", "two_slabs"})
    for (const auto& [name, way] : ways)
      benchmark::RegisterBenchmark(("volume/ways/" + std::string(scene) + "/" + name).c_str(), way_row, scene, way)
          ->Unit(benchmark::kMillisecond)
          ->MeasureProcessCPUTime();
  return true;
}();

}  // namespace
}  // namespace vitrine
