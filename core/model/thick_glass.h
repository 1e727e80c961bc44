// Closed shells that are solid glass, and the way of a ray through them (algorithms 5.2): bent by Snell's law where it enters and
// where it leaves, at the smoothed mesh's interpolated normals. A shell in a shell is the same glass. What the interfaces reflect
// is no part of the path: a ray that finds no way out but total reflection keeps the straight one, and so does one that meets a
// hole or a surface that is not the one the picture shows.
#pragma once

#include <array>
#include <memory>

#include "core/mesh/tri_mesh.h"
#include "core/model/glass_mesh.h"
#include "core/trace/mesh_hits.h"

namespace vitrine {

enum class GlassPath : unsigned char {
  Straight,         // no thick glass, or not where the picture shows a surface
  Bent,             // in and out again
  TotalReflection,  // could not leave
  NoExit,           // met a hole of the shell
};

struct BentRay {
  struct Leg {
    Vec3f origin{}, direction{};
    float length = 0;  // the last one's is infinite
  };
  static constexpr size_t kMostLegs = 8;  // four shells one behind the other; more count as NoExit
  GlassPath path = GlassPath::Straight;
  uint32_t leg_count = 0;  // from the front surface on: inside, outside, inside the next shell, ...; 0 unless bent
  std::array<Leg, kMostLegs> legs{};
};

class ThickGlass {
 public:
  // `ior` > 1. `tolerance`: how far apart the mesh and the depth of the picture may be, scene units, beside 1 %.
  ThickGlass(TriMesh mesh, float ior, float tolerance);

  // `direction` unit; `surface`: the distance at which the picture shows a surface.
  BentRay path(const Vec3f& eye, const Vec3f& direction, float surface) const;

  const TriMesh& mesh() const { return mesh_; }  // closed, smooth, with normals
  float ior() const { return ior_; }
  float tolerance() const { return tolerance_; }

 private:
  Vec3f normal_at(uint32_t face, const Vec3f& point) const;

  TriMesh mesh_;
  float ior_, tolerance_;
  MeshHits hits_;
};

// The chosen regions of the glass (`chosen`: [mesh.regions]), smoothed. nullptr when none is chosen.
std::shared_ptr<const ThickGlass> thick_glass(const GlassMesh& mesh, std::span<const uint8_t> chosen, float ior);

}  // namespace vitrine
