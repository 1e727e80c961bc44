// Process-wide Embree device, and rays as Embree structs. Sources include Embree through embree_version.h; headers
// forward-declare its types.
#pragma once

#include <utility>

#include "core/foundation/math/vec.h"

struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCRayHit;

namespace vitrine::embree {

// Lives until process exit. Throws Error{Dependency} if Embree cannot run on this machine; later failures throw
// Error{Internal}, or Error{Resource} if memory is exhausted.
RTCDeviceTy* device();

RTCRayHit ray_hit(const Vec3f& origin, const Vec3f& direction, float near, float far);

// Owning handle of an Embree scene, initially null. robust() creates one with RTC_SCENE_FLAG_ROBUST: rays do not slip between
// boxes or faces.
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
