// Nearest points of a fixed set: cells of a regular grid, looked through in growing shells.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/math/vec.h"

namespace vitrine {

class PointGrid {
 public:
  // `cell`: about the distance of neighbours.
  PointGrid(std::span<const Vec3f> points, float cell);
  struct Near {
    uint32_t index;
    float squared_distance;
  };
  // At most `count` points within `radius` of p, nearest first; of equal ones the smaller index.
  void nearest(const Vec3f& p, size_t count, float radius, std::vector<Near>& out) const;
  // Whether there is a point within `radius` of p; false for a p that is no number.
  bool any(const Vec3f& p, float radius) const;

 private:
  int64_t coordinate(float x) const;
  static uint64_t key(int64_t x, int64_t y, int64_t z);
  std::span<const Vec3f> points_;
  float cell_;
  std::unordered_map<uint64_t, std::vector<uint32_t>> cells_;
};

}  // namespace vitrine
