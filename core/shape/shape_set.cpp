#include "core/shape/shape_set.h"

#include <algorithm>

namespace vitrine {

namespace {
constexpr double kAlike = 0.9, kBulge = 0.5;  // cosine of the normals; height over the parent, of the tolerance
}

std::optional<ShapeSet::Hit> ShapeSet::first_hit(const Ray& ray, ShapeRole role) const {
  std::optional<Hit> first;
  for (uint32_t i = 0; i < entries.size(); ++i) {
    if (entries[i].role != role) continue;
    if (const auto hit = intersect(entries[i].shape, ray); hit && (!first || hit->t < first->t)) first = Hit{*hit, i};
  }
  if (!first || entries[first->entry].parent < 0) return first;
  const Entry& appendage = entries[first->entry];
  const auto parent = static_cast<uint32_t>(appendage.parent);
  const auto below = intersect(entries[parent].shape, ray);
  if (below && dot(below->normal, first->normal) > kAlike &&
      (below->t - first->t) * length(ray.direction) < kBulge * appendage.tolerance)
    return Hit{*below, parent};
  return first;
}

bool ShapeSet::has(ShapeRole role) const {
  return std::ranges::any_of(entries, [&](const Entry& e) { return e.role == role; });
}

uint32_t ShapeSet::root(uint32_t entry) const {
  while (entries[entry].parent >= 0) entry = static_cast<uint32_t>(entries[entry].parent);
  return entry;
}

}  // namespace vitrine
