// Closed shells that are solid glass (pieces of an extracted mesh, known shapes), and the way of a ray through them
// (algorithms 5.2): bent by Snell's law where it enters and where it leaves, at the smoothed mesh's interpolated normals. Where
// it cannot leave it is mirrored inside (total reflection) and goes on. A shell in a shell is the same glass. What interfaces
// reflect of light that can pass is no part of the path. A ray that is still inside after kMostLegs keeps the straight way, and
// so does one that meets a hole or a surface that is not the one the picture shows.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "core/scene/mesh/tri_mesh.h"
#include "core/render/model/glass_mesh.h"
#include "core/scene/shape/shape_set.h"
#include "core/scene/mesh/mesh_hits.h"

namespace vitrine {

enum class GlassPath : unsigned char {
  Straight,         // no thick glass, or not where the picture shows a surface
  Bent,             // in and out again
  TotalReflection,  // mirrored inside again and again
  NoExit,           // met a hole of the shell
};

struct BentRay {
  struct Leg {
    Vec3f origin{}, direction{};
    float length = 0;  // the last one's is infinite
    float passed = 1;  // of its light at its beginning, by Fresnel's law; all at the first wall, whose reflection the picture has
  };
  static constexpr size_t kMostLegs = 8;  // of a way that is longer the path is TotalReflection inside of glass, NoExit outside
  GlassPath path = GlassPath::Straight;
  uint32_t leg_count = 0;  // from the front surface on: inside (again after each total reflection), outside, ...; 0 unless bent
  std::array<Leg, kMostLegs> legs{};
};

class ThickGlass {
 public:
  // `ior` > 1. `tolerance`: how far apart the mesh and the depth of the picture may be, scene units, beside 1 %.
  ThickGlass(TriMesh mesh, float ior, float tolerance);

  // `direction` unit; `surface`: the distance at which the picture shows a surface.
  BentRay path(const Vec3f& eye, const Vec3f& direction, float surface) const;

  Vec3f normal_at(uint32_t face, const Vec3f& point) const;  // interpolated, outwards
  // How far it is from a place on the shell, or just inside, to the other side; nullopt where the shell has a hole there.
  std::optional<float> thickness(const Vec3f& place, const Vec3f& outward_normal) const;
  // Whether a place is in the glass: most of a few rays from it meet the shell from inside.
  bool contains(const Vec3f& place) const;

  const TriMesh& mesh() const { return mesh_; }  // closed, smooth, with normals
  float ior() const { return ior_; }
  float tolerance() const { return tolerance_; }

 private:
  TriMesh mesh_;
  float ior_, tolerance_;
  MeshHits hits_;
};

// The chosen regions of the glass (`chosen`: [mesh.regions]), smoothed. nullptr when none is chosen.
// The shapes of role Solid. nullptr: there is none.
std::shared_ptr<const ThickGlass> solid_glass(const ShapeSet& shapes);
std::shared_ptr<const ThickGlass> thick_glass(const GlassMesh& mesh, std::span<const uint8_t> chosen, float ior);

}  // namespace vitrine
