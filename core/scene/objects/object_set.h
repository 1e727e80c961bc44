// The table of objects: one identity for everything that is not plain opaque - sheets and blocks of glass, mirrors, coated
// things. The stage `objects` finds it once; every later stage asks it, never a mask of glass or metal.
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
  Opaque,      // matt: nothing to model
  ThinGlass,   // clear sheets that bend no rays
  SolidGlass,  // rays bend at its surface
  Mirror,      // metal, silvered glass
  Coat,        // paint under a clear layer; its surfels show the paint
};
inline constexpr size_t kObjectRoles = 5;
std::string_view name(ObjectRole role);  // "thin_glass"
std::optional<ObjectRole> object_role(std::string_view word);

// How the outlines of an object are known, from weak to strong.
enum class ObjectTrust : unsigned char {
  Guessed,   // by whoever wrote the table: nothing models it
  Detected,  // by a network of the user's, or in the photos alone
  Marked,    // drawn by a person in some photos and propagated to all
  Given,     // masks of the user's own, or a table that a person corrected
};
inline constexpr size_t kObjectTrusts = 4;
std::string_view name(ObjectTrust trust);
std::optional<ObjectTrust> object_trust(std::string_view word);

constexpr bool is_glass(ObjectRole role) { return role == ObjectRole::ThinGlass || role == ObjectRole::SolidGlass; }
constexpr bool is_specular(ObjectRole role) { return role != ObjectRole::Opaque; }  // shows reflections

struct Object {
  uint16_t id = 0;  // as in the label images; 1 ... 65534
  std::string name;
  ObjectRole role = ObjectRole::Opaque;
  ObjectTrust trust = ObjectTrust::Given;

  // What the photos say about it; measured, never read back into a decision.
  struct Evidence {
    size_t views = 0;                                // training photos that show it
    std::optional<double> inside = {};               // share of the pixels of its shapes' silhouettes that the masks mark
    std::optional<double> covered = {};              // share of the marked pixels that these silhouettes cover
    std::optional<double> view_dependence = {};      // of its luminance; of opaque objects
    std::optional<double> straight = {}, bent = {};  // likeness of glass with what straight and bent rays would show
  } evidence = {};
};

struct ObjectSet {
  std::vector<Object> objects;  // ascending ids
  ShapeSet shapes;              // ShapeSet::Entry::object tells whose; roles as those of the objects

  const Object* find(uint16_t id) const;  // nullptr: unknown
  const Object* of_shape(size_t entry) const { return find(shapes.entries[entry].object); }
  bool empty() const { return objects.empty(); }

  // All but guessed ones: those whose ids surfels and vertices carry.
  ObjectSet known() const;
  // The objects that become layers, normals, depths and materials: known ones whose role is not opaque. The one
  // place where trust is decided.
  ObjectSet trusted() const;
  // The shapes that the image formation draws (core/render/model): exact ones of thin glass and mirrors, all of coats.
  ShapeSet drawn_shapes() const;
  // Whether an object is shaded as a mirror of known shape. Without such a shape its surfels show its reflections, as those of a
  // coat do.
  bool is_drawn_mirror(const Object& object) const;

 private:
  ObjectSet kept(const std::function<bool(const Object&)>& keeps) const;
};

ShapeRole shape_role(ObjectRole role);  // Coat for Opaque

// objects/objects.json of an artifact, and the meshes beside it; an empty table where there is no artifact, or none in it. Throws
// Error{Input}.
ObjectSet read_objects(const std::optional<std::filesystem::path>& artifact);
// A table of a user's: its file, or the folder that holds it. Throws Error{Input} with line and column.
ObjectSet read_objects_file(const std::filesystem::path& file);
// Writes objects.json and the meshes into a folder that exists.
void write_objects(const std::filesystem::path& folder, const ObjectSet& set);

}  // namespace vitrine
