// The process's one Embree device, and rays in Embree's form. Embree stays below this folder and mesh_hits.
#pragma once

#include <embree3/rtcore.h>

#include "core/math/vec.h"

namespace vitrine::embree {

// Lives as long as the process. Throws Error{Dependency} when Embree cannot run here; later failures throw Error{Internal}, or
// Error{Resource} when memory is exhausted.
RTCDevice device();

RTCRayHit ray_hit(const Vec3f& origin, const Vec3f& direction, float near, float far);

// Owns a scene.
class Scene {
 public:
  Scene() = default;
  explicit Scene(RTCSceneFlags flags);
  ~Scene();
  Scene(Scene&& other) noexcept : scene_(other.scene_) { other.scene_ = nullptr; }
  Scene& operator=(Scene&& other) noexcept {
    std::swap(scene_, other.scene_);
    return *this;
  }
  RTCScene get() const { return scene_; }

 private:
  RTCScene scene_ = nullptr;
};

}  // namespace vitrine::embree
