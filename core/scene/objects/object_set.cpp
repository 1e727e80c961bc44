#include "core/scene/objects/object_set.h"

#include <algorithm>
#include <array>

namespace vitrine {

namespace {

constexpr std::array<std::string_view, kObjectRoles> kRoleNames{"opaque", "thin_glass", "solid_glass", "mirror", "coat"};
constexpr std::array<std::string_view, kObjectTrusts> kTrustNames{"guessed", "detected", "marked", "given"};

template <class Enum, size_t N>
std::optional<Enum> named(const std::array<std::string_view, N>& names, std::string_view word) {
  const auto at = std::ranges::find(names, word);
  if (at == names.end()) return std::nullopt;
  return static_cast<Enum>(at - names.begin());
}

}  // namespace

std::string_view name(ObjectRole role) { return kRoleNames[static_cast<size_t>(role)]; }
std::optional<ObjectRole> object_role(std::string_view word) { return named<ObjectRole>(kRoleNames, word); }
std::string_view name(ObjectTrust trust) { return kTrustNames[static_cast<size_t>(trust)]; }
std::optional<ObjectTrust> object_trust(std::string_view word) { return named<ObjectTrust>(kTrustNames, word); }

ShapeRole shape_role(ObjectRole role) {
  switch (role) {
    case ObjectRole::ThinGlass:
      return ShapeRole::Sheet;
    case ObjectRole::SolidGlass:
      return ShapeRole::Solid;
    case ObjectRole::Mirror:
      return ShapeRole::Mirror;
    default:
      return ShapeRole::Coat;
  }
}

const Object* ObjectSet::find(uint16_t id) const {
  const auto at = std::ranges::lower_bound(objects, id, {}, &Object::id);
  return at != objects.end() && at->id == id ? &*at : nullptr;
}

ObjectSet ObjectSet::kept(const std::function<bool(const Object&)>& keeps) const {
  ObjectSet out;
  std::ranges::copy_if(objects, std::back_inserter(out.objects), keeps);
  std::vector<uint8_t> keep(shapes.entries.size());
  for (size_t i = 0; i < keep.size(); ++i) keep[i] = out.find(shapes.entries[i].object) != nullptr;
  out.shapes = shapes.kept(keep);
  return out;
}

ObjectSet ObjectSet::known() const {
  return kept([](const Object& o) { return o.trust != ObjectTrust::Guessed; });
}

ObjectSet ObjectSet::trusted() const {
  return kept([](const Object& o) { return o.trust != ObjectTrust::Guessed && o.role != ObjectRole::Opaque; });
}

ShapeSet ObjectSet::drawn_shapes() const {
  std::vector<uint8_t> keep(shapes.entries.size());
  for (size_t i = 0; i < keep.size(); ++i) {
    const Object* object = of_shape(i);
    keep[i] = object != nullptr && (object->role == ObjectRole::Coat || shapes.entries[i].exact);
  }
  return shapes.kept(keep);
}

bool ObjectSet::is_drawn_mirror(const Object& object) const {
  return object.role == ObjectRole::Mirror &&
         std::ranges::any_of(shapes.entries, [&](const ShapeSet::Entry& e) { return e.object == object.id && e.exact; });
}

}  // namespace vitrine
