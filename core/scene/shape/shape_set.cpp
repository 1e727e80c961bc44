#include "core/scene/shape/shape_set.h"

#include <algorithm>

namespace vitrine {

namespace {
constexpr double kAlike = 0.9, kBulge = 0.5;  // cosine of the normals; height over the parent, relative to the tolerance
}

bool ShapeSet::is_bulge(const Hit& appendage, const Hit& parent, const Ray& ray) const {
  const double height = (parent.t - appendage.t) * length(ray.direction);
  return dot(parent.normal, appendage.normal) > kAlike && height < kBulge * entries[appendage.entry].tolerance;
}

bool ShapeSet::has(ShapeRole role) const {
  return std::ranges::any_of(entries, [&](const Entry& e) { return e.role == role; });
}

uint32_t ShapeSet::root(uint32_t entry) const {
  while (entries[entry].parent >= 0) entry = static_cast<uint32_t>(entries[entry].parent);
  return entry;
}

ShapeSet ShapeSet::kept(std::span<const uint8_t> keep) const {
  ShapeSet out;
  std::vector<int> place(entries.size(), -1);  // index in the result
  for (size_t i = 0; i < entries.size(); ++i) {
    const int parent = entries[i].parent;
    if (!keep[i] || (parent >= 0 && place[static_cast<size_t>(parent)] < 0)) continue;
    place[i] = static_cast<int>(out.entries.size());
    Entry& entry = out.entries.emplace_back(entries[i]);
    if (parent >= 0) entry.parent = place[static_cast<size_t>(parent)];
  }
  return out;
}

bool ShapeSet::has_glass() const {
  return std::ranges::any_of(entries, [](const Entry& e) { return is_glass(e.role); });
}

ShapeSet ShapeSet::kept_roles(bool (*keeps)(ShapeRole)) const {
  std::vector<uint8_t> keep;
  for (const Entry& e : entries) keep.push_back(keeps(e.role));
  return kept(keep);
}

ShapeSet ShapeSet::without(ShapeRole role) const {
  std::vector<uint8_t> keep;
  for (const Entry& e : entries) keep.push_back(e.role != role);
  return kept(keep);
}

ShapeSet ShapeSet::glass() const { return kept_roles(is_glass); }
ShapeSet ShapeSet::no_glass() const {
  return kept_roles([](ShapeRole role) { return !is_glass(role); });
}

void ShapeSet::append(ShapeSet more) {
  const auto first = static_cast<int>(entries.size());
  for (Entry& e : more.entries) {
    if (e.parent >= 0) e.parent += first;
    entries.push_back(std::move(e));
  }
}

}  // namespace vitrine
