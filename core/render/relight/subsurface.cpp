#include "core/render/relight/subsurface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"

namespace vitrine {

namespace {

constexpr float kCircle = std::numbers::pi_v<float>;
constexpr uint32_t kLeaf = 4;          // vertices
constexpr float kOpenAngle = 0.35f;    // radius over distance: closer groups are divided
constexpr float kFarthest = 16;        // in d: beyond it less than half a percent of the light leaves
constexpr size_t kTaskVertices = 128;  // vertices of one task

}  // namespace

float diffusion_length(float length, float albedo) {
  const float a = albedo - 0.8f;
  return length / (1.9f - albedo + 3.5f * a * a);
}

float diffusion_profile(float r, float d) { return (std::exp(-r / d) + std::exp(-r / (3 * d))) / (8 * kCircle * d * r); }

float leaves_within(float r, float d) { return 1 - 0.25f * std::exp(-r / d) - 0.75f * std::exp(-r / (3 * d)); }

SubsurfaceFilter::SubsurfaceFilter(const TriMesh& mesh, std::span<const Vec3f> length, std::span<const Vec3f> albedo,
                                   float detail) {
  for (uint32_t v = 0; v < length.size(); ++v)
    if (length[v].x > 0 && length[v].y > 0 && length[v].z > 0) vertices_.push_back(v);
  if (vertices_.empty()) return;
  nodes_.reserve(vertices_.size());
  build(mesh, 0, uint32_t(vertices_.size()));
  std::vector<float> area(mesh.positions.size());
  for (const auto& f : mesh.faces) {
    const Vec3f &a = mesh.positions[f[0]], &b = mesh.positions[f[1]], &c = mesh.positions[f[2]];
    for (const uint32_t v : f) area[v] += vitrine::length(cross(b - a, c - a)) / 6;
  }
  share_.resize(mesh.positions.size());
  for (const uint32_t v : vertices_) {
    places_.push_back(mesh.positions[v]);
    area_.push_back(area[v]);
    Vec3f d;
    for (size_t c = 0; c < 3; ++c) {
      d[c] = diffusion_length(length[v][c], albedo[v][c]);
      share_[v][c] = 1 - leaves_within(detail, d[c]);
    }
    d_.push_back(d);
  }
  for (Node& node : nodes_) {
    Vec3f sum{}, plain{};
    for (uint32_t k = node.first; k < node.last; ++k) {
      node.area += area_[k];
      sum += area_[k] * places_[k], plain += places_[k];
    }
    node.centre = node.area > 0 ? sum / node.area : plain / float(node.last - node.first);
    for (uint32_t k = node.first; k < node.last; ++k)
      node.radius = std::max(node.radius, vitrine::length(places_[k] - node.centre));
  }
}

// Divides the range at the median along its longest side; returns the node.
uint32_t SubsurfaceFilter::build(const TriMesh& mesh, uint32_t first, uint32_t last) {
  const auto self = uint32_t(nodes_.size());
  nodes_.push_back({.first = first, .last = last});
  if (last - first <= kLeaf) return self;
  Vec3f low = mesh.positions[vertices_[first]], high = low;
  for (uint32_t k = first; k < last; ++k)
    for (size_t c = 0; c < 3; ++c) {
      const float x = mesh.positions[vertices_[k]][c];
      low[c] = std::min(low[c], x), high[c] = std::max(high[c], x);
    }
  const Vec3f size = high - low;
  const size_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const uint32_t middle = first + (last - first) / 2;
  std::nth_element(vertices_.begin() + first, vertices_.begin() + middle, vertices_.begin() + last, [&](uint32_t a, uint32_t b) {
    const float x = mesh.positions[a][axis], y = mesh.positions[b][axis];
    return x != y ? x < y : a < b;
  });
  const uint32_t left = build(mesh, first, middle), right = build(mesh, middle, last);
  nodes_[self].left = left, nodes_[self].right = right;
  return self;
}

// `power`: [nodes] sum of area times value; `values`: of vertices_.
Vec3f SubsurfaceFilter::filtered(uint32_t at, std::span<const Vec3f> power, std::span<const Vec3f> values) const {
  const Vec3f &place = places_[at], &d = d_[at];
  const float farthest = kFarthest * std::max({d.x, d.y, d.z});
  // The vertex itself: its area as a disc.
  const float disc = std::sqrt(area_[at] / kCircle);
  Vec3f weight, sum;
  for (size_t c = 0; c < 3; ++c) weight[c] = std::max(leaves_within(disc, d[c]), 1e-6f), sum[c] = weight[c] * values[at][c];
  uint32_t stack[64];
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    const float distance = length(node.centre - place);
    if (distance - node.radius > farthest) continue;
    if (node.radius < kOpenAngle * distance) {
      for (size_t c = 0; c < 3; ++c) {
        const float r = diffusion_profile(distance, d[c]);
        weight[c] += r * node.area, sum[c] += r * power[size_t(&node - nodes_.data())][c];
      }
    } else if (node.left != 0) {
      stack[size++] = node.right, stack[size++] = node.left;
    } else {
      for (uint32_t k = node.first; k < node.last; ++k) {
        // Vertices at one place share the disc.
        const float r = k == at ? 0 : length(places_[k] - place);
        if (!(r > 0)) continue;
        for (size_t c = 0; c < 3; ++c) {
          const float w = area_[k] * diffusion_profile(std::max(r, 0.5f * disc), d[c]);
          weight[c] += w, sum[c] += w * values[k][c];
        }
      }
    }
  }
  return {sum.x / weight.x, sum.y / weight.y, sum.z / weight.z};
}

void SubsurfaceFilter::apply(std::vector<Vec3f>& irradiance) const {
  if (empty()) return;
  std::vector<Vec3f> values(vertices_.size()), power(nodes_.size()), out(vertices_.size());
  for (size_t k = 0; k < values.size(); ++k) values[k] = irradiance[vertices_[k]];
  for (size_t n = 0; n < nodes_.size(); ++n)
    for (uint32_t k = nodes_[n].first; k < nodes_[n].last; ++k) power[n] += area_[k] * values[k];
  parallel_chunks(values.size(), kTaskVertices, [&](size_t, size_t first, size_t last) {
    throw_if_interrupted();
    for (size_t k = first; k < last; ++k) out[k] = filtered(uint32_t(k), power, values);
  });
  for (size_t k = 0; k < out.size(); ++k) irradiance[vertices_[k]] = out[k];
}

}  // namespace vitrine
