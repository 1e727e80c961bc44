#include "core/render/volume/emission_absorption.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/render/volume/cell_nodes.h"
#include "core/render/volume/kernels/cells.h"
#include "core/render/volume/tile_sums.h"

namespace vitrine {

namespace {

constexpr int kDarkest = -50;                               // exponents below count as this: numbers stay normal, which are fast
using EmissionSums = std::array<float, kWhitenedSums + 3>;  // WhitenedSums and the colour

struct ProfileLane {
  RayProfile<float> profile;
  Vec3f offset, closest, direction;  // origin - mean; whitened closest point and direction
  float inverse;                     // 1 / |u'|^2
};

// As kernels/profile.h, without branches.
inline __attribute__((always_inline)) ProfileLane profile_of_ray(const LineIntegrals::Prepared& g, const RayTiles::Tile& tile,
                                                                 size_t i) {
  ProfileLane l;
  l.offset = Vec3f{tile.origin[0][i], tile.origin[1][i], tile.origin[2][i]} - g.mean;
  l.direction = g.matrix * Vec3f{tile.direction[0][i], tile.direction[1][i], tile.direction[2][i]};
  const Vec3f o = g.matrix * l.offset;
  l.inverse = 1.f / squared_length(l.direction);
  l.profile.at = -dot(o, l.direction) * l.inverse;
  l.profile.width = std::sqrt(l.inverse);
  l.closest = o + l.profile.at * l.direction;
  l.profile.depth = g.peak * l.profile.width * exponential<kDarkest>(-0.5f * squared_length(l.closest));
  return l;
}

// exp(-depth) of a cell.
inline __attribute__((always_inline)) float transmitted(float depth) { return exponential<kDarkest>(-depth); }

// At least 1e-20, so that products stay normal numbers; by bits, which no floating-point trap keeps from being a vector.
inline __attribute__((always_inline)) float floored(float transmittance) {
  return std::bit_cast<float>(std::max(std::bit_cast<int32_t>(transmittance), std::bit_cast<int32_t>(1e-20f)));
}

// [cell], of optical depth and the emission of three channels.
struct TileCells {
  alignas(64) std::array<std::array<TileValues, EmissionAbsorption::kMostCells>, 4> values;
  RayCell<float> at(size_t cell, size_t ray) const {
    return {values[0][cell][ray], {values[1][cell][ray], values[2][cell][ray], values[3][cell][ray]}};
  }
  void clear(int cells) {
    for (auto& channel : values) std::fill_n(channel.begin(), cells, TileValues{});
  }
};

// Adds a Gaussian to the cells [first, last] of all rays.
void add_gaussian(const LineIntegrals::Prepared& g, const Vec3f& color, const RayTiles::Tile& tile, std::span<const float> nodes,
                  size_t first, size_t last, TileCells& cells) {
  alignas(64) TileValues depth, at, inverse_width, passed{};
  for (size_t i = 0; i < RayTiles::kRays; ++i) {
    const ProfileLane l = profile_of_ray(g, tile, i);
    depth[i] = l.profile.depth, at[i] = l.profile.at, inverse_width[i] = 1.f / l.profile.width;
  }
  const auto add = [&](size_t cell, const TileValues& part) {
    for (size_t i = 0; i < RayTiles::kRays; ++i) cells.values[0][cell][i] += part[i];
    for (size_t c = 0; c < 3; ++c)
      for (size_t i = 0; i < RayTiles::kRays; ++i) cells.values[1 + c][cell][i] += color[c] * part[i];
  };
  alignas(64) TileValues part;
  for (size_t cell = first; cell < last; ++cell) {
    for (size_t i = 0; i < RayTiles::kRays; ++i) {
      const float now = normal_cdf((nodes[cell] - at[i]) * inverse_width[i]).below;
      part[i] = depth[i] * (now - passed[i]);
      passed[i] = now;
    }
    add(cell, part);
  }
  for (size_t i = 0; i < RayTiles::kRays; ++i) part[i] = depth[i] * (1.f - passed[i]);
  add(last, part);
}

struct TileLight {
  alignas(64) RayVectors color{};
  alignas(64) TileValues transmittance;
};

// Front to back. `before`: transmittance before each cell, where it is wanted.
TileLight light_of(const TileCells& cells, int count, std::vector<TileValues>* before) {
  TileLight out;
  out.transmittance.fill(1.f);
  for (size_t k = 0; k < size_t(count); ++k) {
    if (before != nullptr) before->push_back(out.transmittance);
    for (size_t i = 0; i < RayTiles::kRays; ++i) {
      const RayCell<float> cell = cells.at(k, i);
      VolumeLightf light{{out.color[0][i], out.color[1][i], out.color[2][i]}, out.transmittance[i]};
      add_cell(cell, transmitted(cell.depth), light);
      out.color[0][i] = light.color.x, out.color[1][i] = light.color.y, out.color[2][i] = light.color.z;
      out.transmittance[i] = floored(light.transmittance);
    }
  }
  return out;
}

// Replaces the values of the cells by the gradients by them.
void cells_vjp(const TileLight& gradient, int count, TileCells& cells) {
  std::vector<TileValues> before;
  const TileLight light = light_of(cells, count, &before);
  alignas(64) TileValues behind;
  for (size_t i = 0; i < RayTiles::kRays; ++i) behind[i] = gradient.transmittance[i] * light.transmittance[i];
  for (size_t k = size_t(count); k-- > 0;)
    for (size_t i = 0; i < RayTiles::kRays; ++i) {
      const RayCell<float> cell = cells.at(k, i);
      const Vec3f g{gradient.color[0][i], gradient.color[1][i], gradient.color[2][i]};
      const RayCell<float> out = add_cell_vjp(cell, transmitted(cell.depth), before[k][i], g, behind[i]);
      cells.values[0][k][i] = out.depth;
      cells.values[1][k][i] = out.emission.x, cells.values[2][k][i] = out.emission.y, cells.values[3][k][i] = out.emission.z;
    }
}

// Of the cells [first, last] of a Gaussian: sums of cell gradients times the share of the Gaussian in the cell, per channel, and
// their derivatives by its distance and width.
struct ProfileGradients {
  alignas(64) std::array<TileValues, 4> share;
  alignas(64) TileValues at{}, width{};
};

ProfileGradients profile_gradients(const Vec3f& color, const RayVectors& profile, std::span<const float> nodes, size_t first,
                                   size_t last, const TileCells& gradient) {
  const auto& [depth, at, inverse_width] = profile;
  ProfileGradients out;
  for (size_t c = 0; c < 4; ++c) out.share[c] = gradient.values[c][last];
  alignas(64) TileValues below, density, x, step;
  for (size_t node = first; node < last; ++node) {
    for (size_t i = 0; i < RayTiles::kRays; ++i) {
      x[i] = (nodes[node] - at[i]) * inverse_width[i];
      const NormalCdf cdf = normal_cdf(x[i]);
      below[i] = cdf.below, density[i] = cdf.density * depth[i] * inverse_width[i];
    }
    step.fill(0.f);
    for (size_t c = 0; c < 4; ++c) {
      const float weight = c == 0 ? 1.f : color[c - 1];
      const TileValues &here = gradient.values[c][node], &next = gradient.values[c][node + 1];
      for (size_t i = 0; i < RayTiles::kRays; ++i) {
        const float change = here[i] - next[i];
        out.share[c][i] += below[i] * change;
        step[i] += weight * change;
      }
    }
    for (size_t i = 0; i < RayTiles::kRays; ++i) {
      const float moved = density[i] * step[i];
      out.at[i] -= moved;
      out.width[i] -= x[i] * moved;
    }
  }
  return out;
}

// Sums over the rays of a tile: WhitenedSums, then the colour.
EmissionSums emission_sums(const LineIntegrals::Prepared& g, const Vec3f& color, const RayTiles::Tile& tile,
                           std::span<const float> nodes, size_t first, size_t last, const TileCells& gradient) {
  alignas(64) RayVectors profile, offset, closest, direction;
  for (size_t i = 0; i < RayTiles::kRays; ++i) {
    const ProfileLane l = profile_of_ray(g, tile, i);
    profile[0][i] = l.profile.depth, profile[1][i] = l.profile.at, profile[2][i] = 1.f / l.profile.width;
    offset[0][i] = l.offset.x, offset[1][i] = l.offset.y, offset[2][i] = l.offset.z;
    closest[0][i] = l.closest.x, closest[1][i] = l.closest.y, closest[2][i] = l.closest.z;
    direction[0][i] = l.direction.x, direction[1][i] = l.direction.y, direction[2][i] = l.direction.z;
  }
  const ProfileGradients p = profile_gradients(color, profile, nodes, first, last, gradient);
  alignas(64) TileValues of_depth, inverse, with_width;
  for (size_t i = 0; i < RayTiles::kRays; ++i) {
    const float by_depth = p.share[0][i] + color.x * p.share[1][i] + color.y * p.share[2][i] + color.z * p.share[3][i];
    of_depth[i] = by_depth * profile[0][i];
    inverse[i] = 1.f / (profile[2][i] * profile[2][i]);
    with_width[i] = inverse[i] * (of_depth[i] + p.width[i] / profile[2][i]);
  }
  alignas(64) RayVectors of_origin, of_direction;
  for (size_t axis = 0; axis < 3; ++axis)  // as ray_profile_vjp
    for (size_t i = 0; i < RayTiles::kRays; ++i) {
      const float by_at = p.at[i] * inverse[i];
      of_origin[axis][i] = -of_depth[i] * closest[axis][i] - by_at * direction[axis][i];
      of_direction[axis][i] = profile[1][i] * of_origin[axis][i] - by_at * closest[axis][i] - with_width[i] * direction[axis][i];
    }
  const WhitenedSums white = whitened_sums(tile, offset, of_origin, of_direction);
  EmissionSums out{};
  std::copy(white.begin(), white.end(), out.begin());
  out[kWhitenedSums - 1] = sum_of(of_depth);
  for (size_t c = 0; c < 3; ++c) out[kWhitenedSums + c] = sum_of_products(p.share[1 + c], profile[0]);
  return out;
}

// Pixels of a tile inside the picture: f(ray of the tile, pixel).
template <class F>
void each_pixel(const RayTiles& rays, const RayTiles::Tile& tile, F f) {
  for (int i = 0; i < RayTiles::kRays; ++i) {
    const int x = tile.x + i % RayTiles::kSide, y = tile.y + i / RayTiles::kSide;
    if (x < rays.width() && y < rays.height()) f(size_t(i), size_t(y) * size_t(rays.width()) + size_t(x));
  }
}

}  // namespace

EmissionAbsorption::EmissionAbsorption(const RayTiles& rays, std::span<const Gaussian3f> gaussians, int cells, double cutoff)
    : cells_(cells), lines_(rays, gaussians, cutoff), reach_(lines_.instances()) {
  VITRINE_CHECK(cells >= 2 && cells <= kMostCells, "{} cells of a ray", cells);
  nodes_.resize(rays.tiles().size() * size_t(cells - 1));
  parallel_for(rays.tiles().size(), 1, [&](size_t t) { place_cells(t); });
}

void EmissionAbsorption::place_cells(size_t t) {
  constexpr float kReach = 4;  // standard deviations along the ray, behind which a Gaussian counts as passed: 3e-5 of its depth
  const std::span<const uint32_t> instances = lines_.instances_of_tile(t);
  std::vector<TileProfile> profiles;
  std::vector<std::pair<float, float>> ranges;
  for (const uint32_t instance : instances) {
    const LineIntegrals::Prepared& g = lines_.prepared_at(lines_.gaussian_of(instance));
    alignas(64) TileValues depth, at, width;
    for (size_t i = 0; i < RayTiles::kRays; ++i) {
      const RayProfile<float> p = profile_of_ray(g, lines_.rays().tiles()[t], i).profile;
      depth[i] = p.depth, at[i] = p.at, width[i] = p.width;
    }
    auto& range = ranges.emplace_back(at[0] - kReach * width[0], at[0] + kReach * width[0]);
    for (size_t i = 0; i < RayTiles::kRays; ++i) {
      range.first = std::min(range.first, at[i] - kReach * width[i]);
      range.second = std::max(range.second, at[i] + kReach * width[i]);
    }
    const double sum = double(sum_of(depth));
    const double mean_at = double(sum_of_products(depth, at)) / sum, mean_width = double(sum_of_products(depth, width)) / sum;
    for (float& v : at) v -= static_cast<float>(mean_at);
    for (size_t i = 0; i < RayTiles::kRays; ++i) width[i] = depth[i] * at[i];
    const double spread = double(sum_of_products(width, at)) / sum;
    profiles.push_back({sum / double(RayTiles::kRays), mean_at, std::sqrt(3 * (mean_width * mean_width + spread))});
  }
  const std::vector<float> nodes = cell_nodes(profiles, cells_);
  std::copy(nodes.begin(), nodes.end(), nodes_.begin() + std::ptrdiff_t(t * nodes.size()));
  for (size_t k = 0; k < instances.size(); ++k)
    reach_[instances[k]] = {static_cast<uint8_t>(std::upper_bound(nodes.begin(), nodes.end(), ranges[k].first) - nodes.begin()),
                            static_cast<uint8_t>(std::lower_bound(nodes.begin(), nodes.end(), ranges[k].second) - nodes.begin())};
}

void EmissionAbsorption::forward(std::span<const Vec3f> colors, std::span<VolumeLightf> light) const {
  const RayTiles& rays = lines_.rays();
  VITRINE_CHECK(light.size() == size_t(rays.width()) * size_t(rays.height()) && colors.size() == lines_.gaussians().size(),
                "{} rays and {} colours, of others", light.size(), colors.size());
  parallel_chunks(rays.tiles().size(), 1, [&](size_t t, size_t, size_t) {
    const auto cells = std::make_unique<TileCells>();
    cells->clear(cells_);
    const RayTiles::Tile& tile = rays.tiles()[t];
    for (const uint32_t instance : lines_.instances_of_tile(t)) {
      const uint32_t g = lines_.gaussian_of(instance);
      add_gaussian(lines_.prepared_at(g), colors[g], tile, nodes(t), reach_[instance].first, reach_[instance].last, *cells);
    }
    const TileLight values = light_of(*cells, cells_, nullptr);
    each_pixel(rays, tile, [&](size_t i, size_t pixel) {
      light[pixel] = {{values.color[0][i], values.color[1][i], values.color[2][i]}, values.transmittance[i]};
    });
  });
}

void EmissionAbsorption::backward(std::span<const Vec3f> colors, std::span<const VolumeLightf> gradient,
                                  std::span<Gaussian3Gradient> out, std::span<Vec3f> out_colors) const {
  const RayTiles& rays = lines_.rays();
  const size_t count = lines_.gaussians().size();
  VITRINE_CHECK(gradient.size() == size_t(rays.width()) * size_t(rays.height()) && colors.size() == count &&
                    out.size() == count && out_colors.size() == count,
                "gradients of other rays or Gaussians");
  std::vector<EmissionSums> sums(lines_.instances());
  parallel_for(rays.tiles().size(), 1, [&](size_t t) {
    const auto cells = std::make_unique<TileCells>();
    cells->clear(cells_);
    const RayTiles::Tile& tile = rays.tiles()[t];
    const auto each_instance = [&](auto f) {
      for (const uint32_t instance : lines_.instances_of_tile(t)) f(instance, lines_.gaussian_of(instance), reach_[instance]);
    };
    each_instance([&](uint32_t, uint32_t g, Reach r) {
      add_gaussian(lines_.prepared_at(g), colors[g], tile, nodes(t), r.first, r.last, *cells);
    });
    TileLight of_rays;  // 0 for rays beyond the picture
    of_rays.transmittance.fill(0.f);
    each_pixel(rays, tile, [&](size_t i, size_t pixel) {
      for (size_t c = 0; c < 3; ++c) of_rays.color[c][i] = gradient[pixel].color[c];
      of_rays.transmittance[i] = gradient[pixel].transmittance;
    });
    cells_vjp(of_rays, cells_, *cells);
    each_instance([&](uint32_t instance, uint32_t g, Reach r) {
      sums[instance] = emission_sums(lines_.prepared_at(g), colors[g], tile, nodes(t), r.first, r.last, *cells);
    });
  });
  parallel_for(count, 128, [&](size_t i) {
    std::array<double, EmissionSums{}.size()> total{};
    for (size_t k = lines_.first_instance(i); k < lines_.first_instance(i + 1); ++k)
      for (size_t s = 0; s < total.size(); ++s) total[s] += double(sums[k][s]);
    const Gaussian3Gradient added = gradient_of_sums(lines_.gaussians()[i], std::span(total).first<kWhitenedSums>());
    for (size_t v = 0; v < added.size(); ++v) out[i][v] += added[v];
    for (size_t c = 0; c < 3; ++c) out_colors[i][c] += static_cast<float>(total[kWhitenedSums + c]);
  });
}

}  // namespace vitrine
