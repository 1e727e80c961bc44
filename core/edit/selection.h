// Which surfels and which parts of the mesh a selector means.
//   class      what the photos that see it show inside the masks; what no photo sees belongs to the class when it stands behind
//                the mask in nearly all photos (core/objects/part_labels.h)
//   object     what carries the id of the object (core/objects), as trained and meshed
//   box        the place itself          marks      the place, projected into every marked photo
//   component  faces of the mesh that hang together; surfels near them, and what glass shows inside of them
// The mesh of what stands behind glass is selected as the surfels that glass shows are.
// A face is selected with two of its corners. The reflection layer holds mirrored places: nothing selects it.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/camera/view.h"
#include "core/edit/edit_scene.h"
#include "core/edit/selector.h"
#include "core/image/image.h"
#include "core/mesh/mesh_distance.h"
#include "core/mesh/mesh_topology.h"
#include "core/objects/object_labels.h"

namespace vitrine {

struct MeshComponent {
  size_t faces = 0;
  Bounds3 box;
};

class SceneSelector {
 public:
  // All but the pixels must live as long as this; edits that change materials or delete parts change no selection.
  SceneSelector(const EditScene& scene, std::span<const View> views, ClassPixels pixels);

  // Whether still there or not. Throws Error{Input} at `where` when a class has no masks, or an object or a component does not
  // exist.
  Parts select(const Selector& selector, const std::string& where);
  const std::vector<MeshComponent>& components() const { return components_; }  // from most faces to fewest

  const ObjectSet& objects() const { return pixels_.objects(); }
  // Classes of which there are masks.
  std::vector<MaskClass> classes() const;
  // The component of each surfel of a layer, numbered as in Selector; 0: of none.
  struct SurfelComponents {
    std::vector<uint32_t> diffuse, transmittance;
  };
  const SurfelComponents& surfel_components() const;

 private:
  const Parts& of_class(MaskClass kind, const std::string& where);
  Parts of_object(const std::string& name, const std::string& where) const;
  // What is near a component, or, for what glass shows, inside of one; 0: nothing.
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
  mutable std::optional<SurfelComponents> surfel_components_;  // found once
};

}  // namespace vitrine
