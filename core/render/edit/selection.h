// Selections for editing: the conditions of an edit (Selector, stages/edit/README.md), and the surfels and mesh parts they
// select.
//   class      surfels and vertices that the photos show inside the masks. Parts that no photo sees are selected if they project
//              into the masks of nearly all photos (core/render/picture/part_labels.h).
//   object     surfels and vertices that store the id of the object (core/scene/objects)
//   box        positions inside the box
//   marks      positions that project into the marked region of every marked photo
//   component  a connected component of the mesh, the surfels near it, and the content behind its glass
// The mesh behind glass is selected like the surfels behind glass. A face is selected if two of its vertices are. The
// reflection layer is never selected: it contains mirrored positions.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/render/edit/edit_scene.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/mesh/mesh_distance.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/objects/object_labels.h"

namespace vitrine {

// A region of a photo; it selects positions at any depth.
struct EditMark {
  size_t view = 0;
  std::vector<Vec2d> polygon;  // pixels of the undistorted photo
};

// All given conditions must hold. No condition selects everything.
struct Selector {
  std::optional<MaskClass> kind = {};
  std::optional<std::string> object = {};  // name in the object table
  std::optional<Bounds3> box = {};
  std::vector<EditMark> marks = {};
  std::optional<size_t> component = {};  // of the mesh, 1 = most faces
  std::vector<Selector> except = {};     // at most one; its selection is subtracted

  // True if the selection depends on position alone, not on masks or mesh.
  bool geometric() const { return !kind && !object && !component; }
};

struct MeshComponent {
  size_t faces = 0;
  Bounds3 box;
};

class SceneSelector {
 public:
  // All arguments except the pixels must outlive this object. Material edits and deletions do not change selections.
  SceneSelector(const EditScene& scene, std::span<const View> views, ClassPixels pixels);

  // Includes deleted parts. Throws Error{Input} at `where` if a class has no masks, or an object or component does not exist.
  Parts select(const Selector& selector, const std::string& where);
  const std::vector<MeshComponent>& components() const { return components_; }  // largest first

  const ObjectSet& objects() const { return pixels_.objects(); }
  // Classes with at least one mask.
  std::vector<MaskClass> classes() const;
  // Component of each surfel, numbered as in Selector; 0: none.
  struct SurfelComponents {
    std::vector<uint32_t> diffuse, transmittance;
  };
  const SurfelComponents& surfel_components() const;

 private:
  const Parts& of_class(MaskClass kind, const std::string& where);
  Parts of_object(const std::string& name, const std::string& where) const;
  // component_near: within reach of a component. component_around: also behind its surface (content of glass). 0: none.
  uint32_t component_near(const Vec3f& p) const;
  uint32_t component_around(const Vec3f& p) const;
  Parts of_component(size_t component, const std::string& where) const;
  Parts where_place(const std::function<bool(const Vec3d&)>& inside) const;

  const EditScene& scene_;
  std::span<const View> views_;
  ClassPixels pixels_;
  std::map<MaskClass, Parts> classes_;
  MeshDistance distance_;
  float reach_ = 0;
  std::vector<uint32_t> component_of_face_;  // index into components_
  std::vector<MeshComponent> components_;
  mutable std::optional<SurfelComponents> surfel_components_;  // cached
};

}  // namespace vitrine
