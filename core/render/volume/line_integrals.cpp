#include "core/render/volume/line_integrals.h"

#include <algorithm>
#include <limits>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/render/volume/kernels/density.h"
#include "core/render/volume/kernels/exponential.h"
#include "core/render/volume/tile_sums.h"

namespace vitrine {

namespace {

constexpr int kFarthest = -50;  // exponent of rays far from a Gaussian: denormal products with gradients would be slow
constexpr size_t kGaussiansPerTask = 128;
using Prepared = LineIntegrals::Prepared;
using Tile = RayTiles::Tile;

struct Extent {
  Vec3d mean;  // relative to the pivot
  Whitened<double> white;
  double largest, smallest;  // standard deviations
};

// Whether a ray of the beam may pass within `cutoff` standard deviations. Where it does, it is at |t| <= |mean| + cutoff largest,
// within `width` of the axis.
bool meets(const RayBeam& beam, const Extent& g, double cutoff) {
  const double reach = cutoff * g.largest, width = beam.radius + (length(g.mean) + reach) * beam.spread;
  const Vec3d to = g.mean - beam.axis.origin;
  const double along = dot(to, beam.axis.direction), limit = reach + width;
  if (squared_length(to) - along * along > limit * limit) return false;
  const WhitenedLine<double> line = whitened_line(g.white, g.mean, beam.axis.origin, beam.axis.direction);
  const double whitened_limit = cutoff + width / g.smallest;
  return squared_length(line.closest) <= whitened_limit * whitened_limit;
}

Prepared prepared(const Gaussian3d& g, const Extent& extent) {
  return {cast<float>(extent.white.matrix), cast<float>(extent.mean), static_cast<float>(std::exp(g.log_density) * kSqrtTwoPi)};
}

struct Lane {
  float value;                       // the line integral
  Vec3f offset, closest, direction;  // origin - mean; whitened closest point and direction
  float along, inverse;              // t of the closest point, 1 / |u'|^2
};

// As kernels/density.h, without branches.
inline __attribute__((always_inline)) Lane evaluate(const Prepared& g, const Tile& tile, size_t i) {
  Lane l;
  l.offset = Vec3f{tile.origin[0][i], tile.origin[1][i], tile.origin[2][i]} - g.mean;
  l.direction = g.matrix * Vec3f{tile.direction[0][i], tile.direction[1][i], tile.direction[2][i]};
  const Vec3f o = g.matrix * l.offset;
  l.inverse = 1.f / squared_length(l.direction);
  l.along = -dot(o, l.direction) * l.inverse;
  l.closest = o + l.along * l.direction;
  l.value = g.peak * std::sqrt(l.inverse) * exponential<kFarthest>(-0.5f * squared_length(l.closest));
  return l;
}

void add_integrals(const Prepared& g, const Tile& tile, std::array<float, RayTiles::kRays>& sums) {
  for (size_t i = 0; i < RayTiles::kRays; ++i) sums[i] += evaluate(g, tile, i).value;
}

// Sums over the rays of a tile, as kernels/density.h.
WhitenedSums gradient_sums(const Prepared& g, const Tile& tile, const TileValues& gradient) {
  alignas(64) RayVectors offset, of_origin, of_direction;
  alignas(64) TileValues value;
  for (size_t i = 0; i < RayTiles::kRays; ++i) {
    const Lane l = evaluate(g, tile, i);
    const float part = -gradient[i] * l.value, by_direction = part * l.inverse;
    const Vec3f origin = part * l.closest, direction = l.along * origin + by_direction * l.direction;
    value[i] = l.value;
    offset[0][i] = l.offset.x, offset[1][i] = l.offset.y, offset[2][i] = l.offset.z;
    of_origin[0][i] = origin.x, of_origin[1][i] = origin.y, of_origin[2][i] = origin.z;
    of_direction[0][i] = direction.x, of_direction[1][i] = direction.y, of_direction[2][i] = direction.z;
  }
  WhitenedSums out = whitened_sums(tile, offset, of_origin, of_direction);
  out[12] = sum_of_products(gradient, value);
  return out;
}

}  // namespace

LineIntegrals::LineIntegrals(const RayTiles& rays, std::span<const Gaussian3f> gaussians, double cutoff)
    : rays_(rays), gaussians_(gaussians), prepared_(gaussians.size()), first_(gaussians.size() + 1, 0) {
  std::vector<std::vector<uint32_t>> found(chunk_count(gaussians.size(), kGaussiansPerTask));
  parallel_chunks(gaussians.size(), kGaussiansPerTask, [&](size_t chunk, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Gaussian3d g = cast<double>(gaussians[i]);
      const Extent extent{g.mean - rays.pivot(), whitened(g), std::exp(std::max({g.log_scale.x, g.log_scale.y, g.log_scale.z})),
                          std::exp(std::min({g.log_scale.x, g.log_scale.y, g.log_scale.z}))};
      prepared_[i] = prepared(g, extent);
      const size_t before = found[chunk].size();
      for (const RayTiles::Group& group : rays.groups())
        if (meets(group.beam, extent, cutoff))
          for (const uint32_t t : group.tiles)
            if (meets(rays.tiles()[t].beam, extent, cutoff)) found[chunk].push_back(t);
      first_[i + 1] = found[chunk].size() - before;
    }
  });
  for (size_t i = 0; i < gaussians.size(); ++i) first_[i + 1] += first_[i];
  VITRINE_CHECK(first_.back() < std::numeric_limits<uint32_t>::max(), "{} pairs of Gaussian and tile", first_.back());
  tile_of_.reserve(first_.back());
  for (const auto& part : found) tile_of_.insert(tile_of_.end(), part.begin(), part.end());
  gaussian_of_.resize(tile_of_.size());
  tile_first_.assign(rays.tiles().size() + 1, 0);
  for (const uint32_t t : tile_of_) ++tile_first_[t + 1];
  for (size_t t = 0; t < rays.tiles().size(); ++t) tile_first_[t + 1] += tile_first_[t];
  std::vector<size_t> next(tile_first_.begin(), tile_first_.end() - 1);
  tile_instances_.resize(tile_of_.size());
  for (size_t i = 0; i < gaussians.size(); ++i)
    for (size_t k = first_[i]; k < first_[i + 1]; ++k) {
      gaussian_of_[k] = static_cast<uint32_t>(i);
      tile_instances_[next[tile_of_[k]]++] = static_cast<uint32_t>(k);
    }
}

void LineIntegrals::forward(std::span<float> values) const {
  const size_t width = size_t(rays_.width());
  VITRINE_CHECK(values.size() == width * size_t(rays_.height()), "{} values for other rays", values.size());
  parallel_for(rays_.tiles().size(), 1, [&](size_t t) {
    const Tile& tile = rays_.tiles()[t];
    alignas(64) std::array<float, RayTiles::kRays> sums{};
    for (size_t k = tile_first_[t]; k < tile_first_[t + 1]; ++k)
      add_integrals(prepared_[gaussian_of_[tile_instances_[k]]], tile, sums);
    for (int i = 0; i < RayTiles::kRays; ++i) {
      const int x = tile.x + i % RayTiles::kSide, y = tile.y + i / RayTiles::kSide;
      if (x < rays_.width() && y < rays_.height()) values[size_t(y) * width + size_t(x)] = sums[size_t(i)];
    }
  });
}

void LineIntegrals::backward(std::span<const float> gradient, std::span<Gaussian3Gradient> out) const {
  const size_t width = size_t(rays_.width());
  VITRINE_CHECK(gradient.size() == width * size_t(rays_.height()) && out.size() == gaussians_.size(),
                "gradients of other rays or Gaussians");
  std::vector<WhitenedSums> sums(tile_of_.size());
  parallel_for(rays_.tiles().size(), 1, [&](size_t t) {
    const Tile& tile = rays_.tiles()[t];
    alignas(64) std::array<float, RayTiles::kRays> of_rays{};  // 0 for rays beyond the picture
    for (int i = 0; i < RayTiles::kRays; ++i) {
      const int x = tile.x + i % RayTiles::kSide, y = tile.y + i / RayTiles::kSide;
      if (x < rays_.width() && y < rays_.height()) of_rays[size_t(i)] = gradient[size_t(y) * width + size_t(x)];
    }
    for (size_t k = tile_first_[t]; k < tile_first_[t + 1]; ++k) {
      const uint32_t instance = tile_instances_[k];
      sums[instance] = gradient_sums(prepared_[gaussian_of_[instance]], tile, of_rays);
    }
  });
  parallel_for(gaussians_.size(), kGaussiansPerTask, [&](size_t i) {
    std::array<double, kWhitenedSums> total{};
    for (size_t k = first_[i]; k < first_[i + 1]; ++k)
      for (size_t s = 0; s < kWhitenedSums; ++s) total[s] += double(sums[k][s]);
    const Gaussian3Gradient added = gradient_of_sums(gaussians_[i], total);
    for (size_t v = 0; v < added.size(); ++v) out[i][v] += added[v];
  });
}

}  // namespace vitrine
