#include "core/render/trace/blocks/surfel_bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/foundation/base/parallel.h"
#include "core/render/raster/blocks/block_kernel.h"
#include "core/render/trace/embree/space_order.h"
#include "core/scene/surfels/activation.h"
#include "core/scene/surfels/layers.h"

namespace vitrine::blocks {

namespace {

struct Box {
  static constexpr float kMost = 1e18f;  // squares of sizes stay finite
  float low[3] = {kMost, kMost, kMost}, high[3] = {-kMost, -kMost, -kMost};

  void extend(const Box& other) {
    for (size_t c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], other.low[c]);
      high[c] = std::max(high[c], other.high[c]);
    }
  }
  float half_area() const {
    const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x * y + y * z + z * x;
  }
  bool is_bounded() const {
    for (size_t c = 0; c < 3; ++c)
      if (!(low[c] > -kMost && high[c] < kMost)) return false;
    return true;
  }
};

// Of the ellipse rho <= cut, where alpha is at least 1/255; padded beyond rounding in u and v.
Box bounds_of(const SurfelShape& s) {
  constexpr float kPad = 4e-6f;
  Box box;
  if (!(s.cut.v > 0)) {
    box.low[0] = std::numeric_limits<float>::quiet_NaN();
    return box;
  }
  const float cu = s.cut.v * s.var_u.v * s.var_u.v, cv = s.cut.v * s.var_v.v * s.var_v.v;
  for (size_t c = 0; c < 3; ++c) {
    // axis / |axis|^2 is s_u r0: the half axes of the ellipse.
    const float u = s.axis_u[c].v, v = s.axis_v[c].v, mean = s.mean[c].v;
    const float half = std::sqrt(cu * u * u + cv * v * v);
    const float pad = kPad * (std::abs(mean) + std::sqrt(s.cut.v * std::max(s.var_u.v, s.var_v.v)));
    box.low[c] = mean - half - pad;
    box.high[c] = mean + half + pad;
  }
  return box;
}

struct Range {  // of places
  uint32_t begin = 0, end = 0;
  uint32_t size() const { return end - begin; }
};

// The most places of a node at this depth, so that kLevels levels always suffice.
constexpr uint64_t most_places(uint32_t depth) { return uint64_t{BvhNode::kLeafSize} << 2 * (BvhNode::kLevels - depth); }
static_assert(BvhNode::kChildren == 4 && most_places(0) >= BvhNode::kMostPlaces);

class NodeBuilder {
 public:
  NodeBuilder(const std::vector<Box>& boxes, std::vector<BvhNode>& nodes) : boxes_(boxes), nodes_(nodes) {}

  // Level by level: the nodes of one are divided in parallel and numbered in order.
  void build() {
    std::vector<Range> level;
    if (!boxes_.empty()) level.push_back({0, static_cast<uint32_t>(boxes_.size())});
    for (uint32_t depth = 0; !level.empty(); ++depth) {
      const size_t first = nodes_.size();
      nodes_.resize(first + level.size());
      std::vector<Children> children(level.size());
      parallel_for(level.size(), 8, [&](size_t i) {
        children[i] = divided(level[i], most_places(depth + 1));
        write_boxes(children[i], nodes_[first + i]);
      });
      std::vector<Range> next;
      for (size_t i = 0; i < level.size(); ++i)
        for (size_t c = 0; c < BvhNode::kChildren; ++c) {
          const Range r = children[i][c];
          uint32_t& to = nodes_[first + i].children[c];
          if (r.size() <= BvhNode::kLeafSize) {
            to = r.size() == 0 ? 0 : BvhNode::leaf(r.begin, r.size());
            continue;
          }
          to = static_cast<uint32_t>(nodes_.size() + next.size());
          next.push_back(r);
        }
      level = std::move(next);
    }
  }

 private:
  using Children = std::array<Range, BvhNode::kChildren>;

  Children divided(Range range, uint64_t most) const {
    Children out{range};
    if (range.size() <= BvhNode::kLeafSize) return out;
    const std::array<Range, 2> halves = halved(range, 2 * most);
    size_t count = 0;
    for (const Range& half : halves) {
      if (half.size() <= BvhNode::kLeafSize) {
        out[count++] = half;
        continue;
      }
      for (const Range& quarter : halved(half, most)) out[count++] = quarter;
    }
    return out;
  }

  // At the place with the least surface area heuristic (Goldsmith and Salmon 1987), the one nearest to the middle of those that
  // are equal; no part has more than `most` places.
  std::array<Range, 2> halved(Range range, uint64_t most) const {
    static thread_local std::vector<float> areas_behind;
    const uint32_t n = range.size();
    areas_behind.resize(n);
    Box box;
    for (uint32_t i = n; i-- > 1;) {
      box.extend(boxes_[range.begin + i]);
      areas_behind[i] = box.half_area();
    }
    box = {};
    uint32_t best = 0, best_offset = 0;
    float best_cost = 0;
    for (uint32_t i = 1; i < n; ++i) {
      box.extend(boxes_[range.begin + i - 1]);
      if (i > most || n - i > most) continue;
      const float cost = box.half_area() * leaves(i) + areas_behind[i] * leaves(n - i);
      const uint32_t offset = 2 * i > n ? 2 * i - n : n - 2 * i;
      if (best > 0 && (cost > best_cost || (cost == best_cost && offset >= best_offset))) continue;
      best = i;
      best_cost = cost;
      best_offset = offset;
    }
    return {Range{range.begin, range.begin + best}, Range{range.begin + best, range.end}};
  }
  static float leaves(uint32_t places) { return static_cast<float>((places + BvhNode::kLeafSize - 1) / BvhNode::kLeafSize); }

  void write_boxes(const Children& children, BvhNode& node) const {
    for (size_t c = 0; c < BvhNode::kChildren; ++c) {
      Box box;
      for (uint32_t i = children[c].begin; i < children[c].end; ++i) box.extend(boxes_[i]);
      for (size_t axis = 0; axis < 3; ++axis) {
        node.planes[0][axis].v[c] = box.low[axis];
        node.planes[1][axis].v[c] = box.high[axis];
      }
    }
  }

  const std::vector<Box>& boxes_;
  std::vector<BvhNode>& nodes_;
};

}  // namespace

SurfelBvh build_surfel_bvh(const SplatLayer& layer) {
  constexpr size_t kChunk = 4096;  // surfels
  const size_t n = layer.size();
  if (n > BvhNode::kMostPlaces) throw ExecutorOverflow("surfels");
  embree::SpaceOrder order;
  order.build(layer);
  std::vector<SurfelShape> shapes(n);
  std::vector<Box> boxes(n);
  parallel_chunks(n, kChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const size_t surfel = order.surfel_at[i];
      const float *m = layer.at(Attribute::Mean, surfel), *q = layer.at(Attribute::Rotation, surfel),
                  *s = layer.at(Attribute::LogScale, surfel);
      const SurfelGeometry<F32> raw{{m[0], m[1], m[2]}, {q[0], q[1], q[2], q[3]}, s[0], s[1]};
      static_cast<RaySurfel<F32>&>(shapes[i]) = ray_surfel(raw, sigmoid(F32(*layer.at(Attribute::Opacity, surfel))));
      boxes[i] = bounds_of(shapes[i]);
    }
  });
  SurfelBvh bvh;
  bvh.place_of.assign(n, SurfelBvh::kInvisible);
  Box all;
  size_t places = 0;
  for (size_t i = 0; i < n; ++i) {
    if (!boxes[i].is_bounded()) continue;
    bvh.place_of[order.surfel_at[i]] = static_cast<uint32_t>(places);
    bvh.surfel_at.push_back(order.surfel_at[i]);
    shapes[places] = shapes[i];
    boxes[places++] = boxes[i];
    all.extend(boxes[i]);
  }
  shapes.resize(places);
  boxes.resize(places);
  bvh.shapes = std::move(shapes);
  for (size_t c = 0; c < 3 && places > 0; ++c) {
    bvh.low[c] = all.low[c];
    bvh.high[c] = all.high[c];
  }
  NodeBuilder(boxes, bvh.nodes).build();
  return bvh;
}

}  // namespace vitrine::blocks
