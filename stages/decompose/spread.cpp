#include "stages/decompose/lit_points.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/kd_tree.h"
#include "core/foundation/math/rigid.h"
#include "core/foundation/math/spherical_harmonics.h"

namespace vitrine {

namespace {

constexpr float kReach = 8;            // times the radius: largest distance of a used point
constexpr float kLeastFacing = 0.01f;  // weight of a point with a perpendicular normal
constexpr float kAcross = 0.3f;        // largest cosine of a perpendicular normal

struct PointSet {
  std::vector<Vec3f> positions;
  std::vector<uint32_t> index;
};

Vec3f at3(const SplatLayer& layer, Attribute a, size_t i) {
  const float* v = layer.at(a, i);
  return {v[0], v[1], v[2]};
}

Vec3f normal_of(const SplatLayer& layer, size_t i) {
  const float* q = layer.at(Attribute::Rotation, i);
  return rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})).c2;
}

}  // namespace

std::vector<Vec3f> spread_irradiance(const SplatLayer& layer, const Bounds3& inner, std::span<const LitPoint> points,
                                     std::span<const Vec3f> irradiance, const std::vector<bool>& usable, const SpreadDesc& desc) {
  PointSet sets[2];  // outside, inside
  Vec3d sum{};
  double count = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (!usable[i]) continue;
    PointSet& set = sets[points[i].inner];
    set.positions.push_back(points[i].position);
    set.index.push_back(static_cast<uint32_t>(i));
    sum += cast<double>(irradiance[i]);
    count += 1;
  }
  const Vec3f mean = count > 0 ? cast<float>(sum / count) : Vec3f{1, 1, 1};
  const float radius[2] = {desc.outer_radius, desc.inner_radius};
  const KdTreef trees[2] = {KdTreef(sets[0].positions), KdTreef(sets[1].positions)};
  std::vector<Vec3f> out(layer.size());
  parallel_for(layer.size(), 256, [&](size_t i) {
    const Vec3f p = at3(layer, Attribute::Mean, i), n = normal_of(layer, i);
    const size_t which = inner.contains(p);
    std::vector<KdTreef::Near> near;
    trees[which].nearest(p, desc.neighbours, kReach * radius[which], near);
    const float inverse = 1 / (2 * radius[which] * radius[which]);
    // Relative to the nearest: a surfel far from all points still gets their light.
    const auto closeness = [&](const KdTreef::Near& q) {
      return std::exp(-inverse * (q.squared_distance - near.front().squared_distance));
    };
    const auto facing_of = [&](const KdTreef::Near& q) { return dot(n, points[sets[which].index[q.index]].normal); };
    // The front side of a surfel is that of its nearest points; points on the other side of a thin object are farther away.
    float front = 0;
    for (const KdTreef::Near& q : near) front += closeness(q) * facing_of(q);
    Vec3f total{};
    float weight = 0;
    for (const KdTreef::Near& q : near) {
      const float facing = std::copysign(1.f, front) * facing_of(q), square = facing * facing;
      if (facing < -kAcross) continue;
      const float w = closeness(q) * (facing > 0 ? std::max(kLeastFacing, square * square) : kLeastFacing);
      total += w * irradiance[sets[which].index[q.index]];
      weight += w;
    }
    out[i] = weight > 0 ? total / weight : mean;
  });
  return out;
}

std::vector<Vec3f> surfel_radiance(const SplatLayer& layer, std::span<const Vec3f> eyes) {
  const int degree = layer.sh_degree();
  const size_t coefficients = sh_coefficient_count(degree);
  std::vector<Vec3f> out(layer.size());
  parallel_for(layer.size(), 256, [&](size_t i) {
    constexpr float kInFront = 0.2f;
    const Vec3f p = at3(layer, Attribute::Mean, i), n = normal_of(layer, i);
    float basis[16], mean[16] = {kShDc};
    float weight = 0;
    if (degree > 0)
      for (const Vec3f& eye : eyes) {
        const Vec3f towards = normalized(eye - p);
        const float cosine = std::abs(dot(n, towards));
        if (!(cosine > kInFront)) continue;
        sh_basis(degree, -towards, basis);
        for (size_t k = 1; k < coefficients; ++k) mean[k] += cosine * basis[k];
        weight += cosine;
      }
    const float* rest = degree > 0 ? layer.at(Attribute::ShRest, i) : nullptr;
    for (size_t c = 0; c < 3; ++c) {
      float value = 0.5f + mean[0] * layer.at(Attribute::ShDc, i)[c];
      if (weight > 0)
        for (size_t k = 1; k < coefficients; ++k) value += mean[k] / weight * rest[3 * (k - 1) + c];
      out[i][c] = std::max(0.f, value);
    }
  });
  return out;
}

}  // namespace vitrine
