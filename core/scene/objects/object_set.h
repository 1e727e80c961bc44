// Object table: one id for every object that is not plain opaque (thin and solid glass, mirrors, coated objects). The stage
// `objects` creates it; all later stages read it instead of glass or specular masks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/shape/shape_set.h"

namespace vitrine {

enum class ObjectRole : unsigned char {
  Opaque,      // diffuse, no special model
  ThinGlass,   // clear thin glass that does not refract
  SolidGlass,  // rays refract at its surface
  Mirror,      // metal, silvered glass
  Coat,        // paint under a clear coat; its surfels show the paint
};
inline constexpr size_t kObjectRoles = 5;
std::string_view name(ObjectRole role);  // "thin_glass"
std::optional<ObjectRole> object_role(std::string_view word);

// Source of the outlines of an object, from weak to strong.
enum class ObjectTrust : unsigned char {
  Guessed,   // by the author of the table; not modelled
  Detected,  // by a user's network, or from the photos alone
  Marked,    // annotated by a person in some photos and propagated to all
  Given,     // masks of the user, or a table corrected by a person
};
inline constexpr size_t kObjectTrusts = 4;
std::string_view name(ObjectTrust trust);
std::optional<ObjectTrust> object_trust(std::string_view word);

constexpr bool is_glass(ObjectRole role) { return role == ObjectRole::ThinGlass || role == ObjectRole::SolidGlass; }
constexpr bool is_specular(ObjectRole role) { return role != ObjectRole::Opaque; }  // has reflections

struct Object {
  uint16_t id = 0;  // id in the label images; 1 ... 65534
  std::string name;
  ObjectRole role = ObjectRole::Opaque;
  ObjectTrust trust = ObjectTrust::Given;

  // Measured support in the photos; for reports only, never used in decisions.
  struct Evidence {
    size_t views = 0;                                // training photos that show it
    std::optional<double> inside = {};               // fraction of the silhouette pixels of its shapes that the masks mark
    std::optional<double> covered = {};              // fraction of the marked pixels covered by these silhouettes
    std::optional<double> view_dependence = {};      // of luminance; opaque objects only
    std::optional<double> straight = {}, bent = {};  // similarity of glass to renderings with straight and refracted rays
  } evidence = {};
};

struct ObjectSet {
  std::vector<Object> objects;  // ascending ids
  ShapeSet shapes;              // ShapeSet::Entry::object is the owner; roles as those of the objects

  const Object* find(uint16_t id) const;  // nullptr: unknown
  const Object* of_shape(size_t entry) const { return find(shapes.entries[entry].object); }
  bool empty() const { return objects.empty(); }

  // All except guessed ones; surfels and vertices store the ids of these.
  ObjectSet known() const;
  // Objects that become layers, normals, depths and materials: known ones whose role is not opaque. The only place where trust
  // is evaluated.
  ObjectSet trusted() const;
  // Shapes rendered by the image formation model (core/render/model): exact ones of thin glass and mirrors, all of coats.
  ShapeSet drawn_shapes() const;
  // True if the object is rendered as a mirror of known shape. Otherwise its surfels show its reflections, as for a coat.
  bool is_drawn_mirror(const Object& object) const;

 private:
  ObjectSet kept(const std::function<bool(const Object&)>& keeps) const;
};

ShapeRole shape_role(ObjectRole role);  // Coat for Opaque

// Reads objects/objects.json of an artifact and the meshes next to it; an empty table if there is no artifact or no table in
// it. Throws Error{Input}.
ObjectSet read_objects(const std::optional<std::filesystem::path>& artifact);
// Reads a user's table: the file, or the folder that contains it. Throws Error{Input} with line and column.
ObjectSet read_objects_file(const std::filesystem::path& file);
// Writes objects.json and the meshes into an existing folder.
void write_objects(const std::filesystem::path& folder, const ObjectSet& set);

}  // namespace vitrine
