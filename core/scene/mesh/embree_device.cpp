#include "core/scene/mesh/embree_device.h"

#include <string>

#include "core/foundation/base/error.h"
#include "core/scene/mesh/embree_version.h"

namespace vitrine::embree {

namespace {

void on_error(void*, RTCError code, const char* text) {
  throw Error(code == RTC_ERROR_OUT_OF_MEMORY ? ErrorKind::Resource : ErrorKind::Internal, "Embree failed",
              {.why = text ? text : "", .hint = "fewer surfels or faces, if memory is short", .code = "EMBREE"});
}

// ThreadSanitizer cannot see the synchronisation of libembree's threads: its build constructs BVHs on the calling thread.
#ifdef __SANITIZE_THREAD__
constexpr const char* kSettings = "threads=1";
#else
constexpr const char* kSettings = nullptr;
#endif

struct Device {
  RTCDevice device = rtcNewDevice(kSettings);
  Device() {
    if (!device)
      throw Error(ErrorKind::Dependency, "Embree has no device on this machine",
                  {.why = fmt::format("its error is {}", static_cast<int>(rtcGetDeviceError(nullptr))),
                   .hint = fmt::format("install Embree {0}: apt-get install libembree{0}-{0}", RTC_VERSION_MAJOR),
                   .code = "EMBREE"});
    rtcSetDeviceErrorFunction(device, on_error, nullptr);
  }
  ~Device() { rtcReleaseDevice(device); }
};

}  // namespace

RTCDeviceTy* device() {
  static const Device instance;
  return instance.device;
}

RTCRayHit ray_hit(const Vec3f& origin, const Vec3f& direction, float near, float far) {
  RTCRayHit r{};
  r.ray.org_x = origin.x, r.ray.org_y = origin.y, r.ray.org_z = origin.z;
  r.ray.dir_x = direction.x, r.ray.dir_y = direction.y, r.ray.dir_z = direction.z;
  r.ray.tnear = near;
  r.ray.tfar = far;
  r.ray.mask = 0xffffffffu;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return r;
}

Scene Scene::robust() {
  Scene s;
  s.scene_ = rtcNewScene(device());
  rtcSetSceneFlags(s.scene_, RTC_SCENE_FLAG_ROBUST);
  return s;
}
Scene::~Scene() {
  if (scene_) rtcReleaseScene(scene_);
}

}  // namespace vitrine::embree
