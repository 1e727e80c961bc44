// The process's one Embree device, and rays in Embree's form. Embree stays in the sources below this folder and in mesh_hits.cpp;
// headers only name its types.
#pragma once

#include <utility>

#include "core/foundation/math/vec.h"

struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCRayHit;

namespace vitrine::embree {

// Lives as long as the process. Throws Error{Dependency} when Embree cannot run here; later failures throw Error{Internal}, or
// Error{Resource} when memory is exhausted.
RTCDeviceTy* device();

RTCRayHit ray_hit(const Vec3f& origin, const Vec3f& direction, float near, float far);

// Owns a scene, empty at first, of the robust kind: rays do not slip between boxes or faces.
class Scene {
 public:
  Scene() = default;
  static Scene robust();
  ~Scene();
  Scene(Scene&& other) noexcept : scene_(other.scene_) { other.scene_ = nullptr; }
  Scene& operator=(Scene&& other) noexcept {
    std::swap(scene_, other.scene_);
    return *this;
  }
  RTCSceneTy* get() const { return scene_; }

 private:
  RTCSceneTy* scene_ = nullptr;
};

}  // namespace vitrine::embree
