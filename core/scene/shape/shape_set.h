// The shapes that a scene knows, and the one rule which of them a ray shows: the nearest hit of all.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/shape/shape.h"

namespace vitrine {

enum class ShapeRole : unsigned char {
  Mirror,  // an opaque surface that mirrors
  Sheet,   // thin clear glass: its facets are panes
  Coat,    // a clear layer over paint, which its surfels show
  Solid,   // a block of clear glass: rays bend at its walls
};
constexpr bool is_glass(ShapeRole role) { return role == ShapeRole::Sheet || role == ShapeRole::Solid; }

struct ShapeSet {
  struct Entry {
    Shape shape;
    ShapeRole role = ShapeRole::Mirror;
    double tolerance = 0;        // how far from it surfels that show it lie, scene units, > 0
    int parent = -1;             // of an appendage, a handle: the entry that it stands out of, before it and of the same role
    std::vector<uint8_t> clear;  // [facet] of a sheet: 0 where it stands on something or is a frame; empty: all are panes
    bool exact = true;           // its normals are better than those of surfels; false: a visual hull, a poor fit
    uint16_t object = 0;         // id in the table of objects (core/scene/objects), 0: of none
    double layered = 1;          // share of the layers in pictures that have an opaque twin (core/render/model/opaque_pass.h)
    bool is_clear(size_t facet) const { return facet >= clear.size() || clear[facet] != 0; }
  };
  std::vector<Entry> entries;

  struct Hit : ShapeHit {
    uint32_t entry = 0;
  };
  // The nearest hit of all entries of the role that `accepts` (bool(const Hit&)), the first of equal ones. Where an appendage is
  // no more than a bulge of its parent, with like normals less than half its tolerance in front of it, the parent is hit.
  template <class Accepts>
  std::optional<Hit> first_hit(const Ray& ray, ShapeRole role, const Accepts& accepts) const;
  std::optional<Hit> first_hit(const Ray& ray, ShapeRole role) const {
    return first_hit(ray, role, [](const Hit&) { return true; });
  }

  bool has(ShapeRole role) const;
  bool has_glass() const;
  uint32_t root(uint32_t entry) const;  // without parent
  // The entries with keep[i] != 0 whose parents are kept as well.
  ShapeSet kept(std::span<const uint8_t> keep) const;
  ShapeSet without(ShapeRole role) const;
  ShapeSet glass() const;     // sheets and solids
  ShapeSet no_glass() const;  // the others
  // Adds the entries of another set behind these.
  void append(ShapeSet more);

 private:
  ShapeSet kept_roles(bool (*keeps)(ShapeRole)) const;
  bool is_bulge(const Hit& appendage, const Hit& parent, const Ray& ray) const;
};

template <class Accepts>
std::optional<ShapeSet::Hit> ShapeSet::first_hit(const Ray& ray, ShapeRole role, const Accepts& accepts) const {
  std::optional<Hit> first;
  for (uint32_t i = 0; i < entries.size(); ++i) {
    if (entries[i].role != role) continue;
    const auto hit = intersect(entries[i].shape, ray);
    if (hit && (!first || hit->t < first->t) && accepts(Hit{*hit, i})) first = Hit{*hit, i};
  }
  if (!first || entries[first->entry].parent < 0) return first;
  const auto parent = static_cast<uint32_t>(entries[first->entry].parent);
  const auto below = intersect(entries[parent].shape, ray);
  if (below && is_bulge(*first, Hit{*below, parent}, ray) && accepts(Hit{*below, parent})) return Hit{*below, parent};
  return first;
}

// Empty sets are nullptr.
inline bool knows(const ShapeSet* set, ShapeRole role) { return set != nullptr && set->has(role); }

}  // namespace vitrine
