// Refraction through solid glass: closed meshes (parts of an extracted mesh, known shapes) and the path of a ray through them
// (algorithms 5.2). The ray is refracted by Snell's law at entry and exit, with the interpolated normals of the smoothed mesh;
// at total internal reflection it is reflected inside and continues. A mesh nested in another is the same glass. Partial
// reflections at the interfaces are not part of the path. The ray stays straight if it is still inside after kMostLegs
// segments, hits a hole, or hits a surface that is not the one shown in the picture.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "core/render/model/glass_segments.h"
#include "core/scene/mesh/mesh_hits.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/shape_set.h"

namespace vitrine {

enum class GlassPath : unsigned char {
  Straight,         // no thick glass, or none at the surface shown in the picture
  Bent,             // entered and left
  TotalReflection,  // total internal reflections up to the limit
  NoExit,           // hit a hole of the mesh
};

struct BentRay {
  struct Leg {
    Vec3f origin{}, direction{};
    float length = 0;  // of the last segment: infinite
    float passed = 1;  // Fresnel transmittance at its start; 1 at the first wall, whose reflection is in the picture
  };
  static constexpr size_t kMostLegs = 8;  // longer paths are TotalReflection if inside glass, NoExit if outside
  GlassPath path = GlassPath::Straight;
  uint32_t leg_count = 0;  // from the front surface: inside (again after total reflection), outside, ...; 0 unless Bent
  std::array<Leg, kMostLegs> legs{};
};

class ThickGlass {
 public:
  // `ior` > 1. `tolerance`: maximum distance between the mesh and the depth of the picture, scene units, in addition to 1 %.
  ThickGlass(TriMesh mesh, float ior, float tolerance);

  // `direction` unit; `surface`: distance of the surface shown in the picture.
  BentRay path(const Vec3f& eye, const Vec3f& direction, float surface) const;

  Vec3f normal_at(uint32_t face, const Vec3f& point) const;  // interpolated, outwards
  // Distance from a point on or just inside the mesh to the opposite side; nullopt if the mesh has a hole there.
  std::optional<float> thickness(const Vec3f& place, const Vec3f& outward_normal) const;
  // Whether a point is in the glass: most of a few rays from it hit the mesh from inside.
  bool contains(const Vec3f& place) const;

  const TriMesh& mesh() const { return mesh_; }  // closed, smooth, with normals
  float ior() const { return ior_; }
  float tolerance() const { return tolerance_; }

 private:
  TriMesh mesh_;
  float ior_, tolerance_;
  MeshHits hits_;
};

// Selected regions of the glass mesh (`chosen`: [mesh.regions]), smoothed. nullptr if none is selected.
// Shapes of role Solid. nullptr: none.
std::shared_ptr<const ThickGlass> solid_glass(const ShapeSet& shapes);
std::shared_ptr<const ThickGlass> thick_glass(const GlassMesh& mesh, std::span<const uint8_t> chosen, float ior);

}  // namespace vitrine
