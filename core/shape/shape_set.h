// The shapes that a scene knows, and the one rule which of them a ray shows: the nearest hit of all.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/shape/shape.h"

namespace vitrine {

enum class ShapeRole : unsigned char {
  Mirror,  // an opaque surface that mirrors
  Sheet,   // thin clear glass: its facets are panes
};

struct ShapeSet {
  struct Entry {
    Shape shape;
    ShapeRole role = ShapeRole::Mirror;
    double tolerance = 0;        // how far from it surfels that show it lie, scene units, > 0
    int parent = -1;             // of an appendage, a handle: the entry that it stands out of
    std::vector<uint8_t> clear;  // [facet] of a sheet: 0 where it stands on something or is a frame; empty: all are panes
    bool is_clear(size_t facet) const { return facet >= clear.size() || clear[facet] != 0; }
  };
  std::vector<Entry> entries;

  struct Hit : ShapeHit {
    uint32_t entry = 0;
  };
  // The nearest hit of all entries of the role, the first of equal ones. Where an appendage is no more than a bulge of its
  // parent, with like normals less than half its tolerance in front of it, the parent is hit.
  std::optional<Hit> first_hit(const Ray& ray, ShapeRole role) const;

  bool has(ShapeRole role) const;
  uint32_t root(uint32_t entry) const;  // without parent
};

// Empty sets are nullptr.
inline bool knows(const ShapeSet* set, ShapeRole role) { return set != nullptr && set->has(role); }

}  // namespace vitrine
