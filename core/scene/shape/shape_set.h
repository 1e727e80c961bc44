// The set of shapes of a scene. A ray hits the nearest of them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/shape/shape.h"

namespace vitrine {

enum class ShapeRole : unsigned char {
  Mirror,  // opaque mirror surface
  Sheet,   // thin clear glass; its facets are panes
  Coat,    // clear coat over paint; its surfels show the paint
  Solid,   // solid clear glass: rays refract at its walls
};
constexpr bool is_glass(ShapeRole role) { return role == ShapeRole::Sheet || role == ShapeRole::Solid; }

struct ShapeSet {
  struct Entry {
    Shape shape;
    ShapeRole role = ShapeRole::Mirror;
    double tolerance = 0;  // maximum distance of surfels of this shape from it, scene units, > 0
    int parent = -1;       // for an appendage (a handle): index of the entry it is attached to, smaller than its own, same role
    std::vector<uint8_t> clear;  // [facet] of thin glass: 0 = opaque (support or frame); empty: all are panes
    bool exact = true;           // normals are more accurate than those of surfels; false: visual hull or poor fit
    uint16_t object = 0;         // id in the object table (core/scene/objects), 0 = none
    double layered = 1;          // weight of the layers in images that have an opaque twin (core/render/model/opaque_pass.h)
    bool is_clear(size_t facet) const { return facet >= clear.size() || clear[facet] != 0; }
  };
  std::vector<Entry> entries;

  struct Hit : ShapeHit {
    uint32_t entry = 0;
  };
  // Nearest hit over all entries of roles that `accepts` (bool(const Hit&)); ties: the first entry. An appendage hit counts as
  // a hit of the parent if the normals are similar and it is less than half its tolerance in front of the parent.
  template <class Accepts>
  std::optional<Hit> first_hit(const Ray& ray, ShapeRole role, const Accepts& accepts) const;
  std::optional<Hit> first_hit(const Ray& ray, ShapeRole role) const {
    return first_hit(ray, role, [](const Hit&) { return true; });
  }

  bool has(ShapeRole role) const;
  bool has_glass() const;
  uint32_t root(uint32_t entry) const;  // topmost ancestor
  // Entries with keep[i] != 0 whose parents are kept too.
  ShapeSet kept(std::span<const uint8_t> keep) const;
  ShapeSet without(ShapeRole role) const;
  ShapeSet glass() const;     // thin and solid glass
  ShapeSet no_glass() const;  // the others
  // Appends the entries of another set.
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

// Null-safe test for a role.
inline bool knows(const ShapeSet* set, ShapeRole role) { return set != nullptr && set->has(role); }

// Uniform samples on the surface of a shape, for placing surfels.

// About one point per square of edge `spacing` > 0: a low-discrepancy sequence per triangle (Roberts, "The unreasonable
// effectiveness of quasirandom sequences", 2018), projected onto the surface. Deterministic.
std::vector<ShapePoint> surface_samples(const Shape& shape, double spacing);

}  // namespace vitrine
