// Photos with their targets in the memory of a device, as they are kept on the host. They stay there until they take half of the
// memory that was free before the first of their level; the others are copied for each step.
#pragma once

#include <array>
#include <map>

#include "core/learn/trainer/blocks/photo_kernels.h"
#include "core/learn/trainer/blocks/step_pass.h"

namespace vitrine::blocks {

template <class Executor>
class PhotoStore {
 public:
  // The photo with all pointers of the device.
  StepPhoto there(Executor& executor, const StepPhoto& here) {
    if (photos_.empty() || here.level != level_) {
      photos_.clear();
      level_ = here.level;
      budget_ = executor.free_memory() / 2;
    }
    const auto found = photos_.find(here.photo);
    if (found != photos_.end()) return pointers(found->second, here);
    if (bytes(here) > budget_) {
      upload(executor, passing_, here);
      return pointers(passing_, here);
    }
    budget_ -= bytes(here);
    Arrays& arrays = photos_[here.photo];
    upload(executor, arrays, here);
    return pointers(arrays, here);
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;
  struct Arrays {
    Array<uint16_t> srgb;
    Array<uint8_t> planes;
    Array<int16_t> normals;
  };
  static constexpr std::array<const uint8_t * StepPhoto::*, 6> kPlanes{&StepPhoto::specular, &StepPhoto::transparent,
                                                                       &StepPhoto::object,   &StepPhoto::ignore,
                                                                       &StepPhoto::coat,     &StepPhoto::confidence};

  static size_t plane_bytes(const StepPhoto& photo) {
    size_t planes = 0;
    for (const auto plane : kPlanes) planes += photo.*plane != nullptr;
    return planes * photo.pixels;
  }
  static size_t bytes(const StepPhoto& photo) {
    return (photo.normals == nullptr ? 1 : 2) * size_t{6} * photo.pixels + plane_bytes(photo);
  }
  static void upload(Executor& executor, Arrays& to, const StepPhoto& here) {
    const size_t pixels = here.pixels;
    to.srgb.resize(3 * pixels);
    executor.upload(to.srgb.data(), here.srgb, 3 * pixels);
    to.planes.resize(plane_bytes(here));
    uint8_t* next = to.planes.data();
    for (const auto plane : kPlanes) {
      if (here.*plane == nullptr) continue;
      executor.upload(next, here.*plane, pixels);
      next += pixels;
    }
    if (here.normals == nullptr) return;
    to.normals.resize(3 * pixels);
    executor.upload(to.normals.data(), here.normals, 3 * pixels);
  }
  static StepPhoto pointers(Arrays& arrays, const StepPhoto& here) {
    StepPhoto there = here;
    there.srgb = arrays.srgb.data();
    const uint8_t* next = arrays.planes.data();
    for (const auto plane : kPlanes) {
      if (here.*plane == nullptr) continue;
      there.*plane = next;
      next += here.pixels;
    }
    if (here.normals != nullptr) there.normals = arrays.normals.data();
    return there;
  }

  std::map<uint32_t, Arrays> photos_;
  Arrays passing_;  // of the last photo that does not stay
  uint32_t level_ = 0;
  size_t budget_ = 0;
};

}  // namespace vitrine::blocks
