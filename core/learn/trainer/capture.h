// Training photos: display-referred, at full, half and quarter size (reduced in linear light).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/camera/view_set.h"
#include "core/scene/image/image.h"

namespace vitrine {

inline constexpr size_t kLevels = 3;  // full, half, quarter

struct PhotoLevel {
  View view;                   // intrinsics at this size
  std::vector<uint16_t> srgb;  // [3,h,w], 65535 = 1
};

struct PhotoPyramid {
  std::array<PhotoLevel, kLevels> levels;
  const std::string& name() const { return levels[0].view.name; }
};

struct Capture {
  ViewSet view_set;
  std::vector<PhotoPyramid> photos;      // in the order of view_set.views
  std::vector<uint32_t> train, heldout;  // indices into photos
  // Near plane: half the depth of the nearest sparse points, at most a tenth of the radius of the camera ring. Stray surfels
  // closer than that would veil cameras that pass by.
  float near_z = 0.01f;
  size_t largest_pixel_count = 0;
  size_t memory_bytes = 0;  // of the pyramids
};

// Replaces the poses by those of an optimize artifact (core/scene/camera/corrected_poses.h).
void use_corrected_poses(const std::filesystem::path& optimize_folder, Capture& capture);

// Pyramid of one photo. `linear` has the size of the view's intrinsics.
PhotoPyramid make_photo(const View& view, const ImageF& linear, int max_side);
// Scene-linear colour of a pixel, divided by its photo's gain.
Vec3f linear_at(const PhotoLevel& photo, size_t pixel);
// Planar [3,h,w] floats of a level.
void decode(const PhotoLevel& level, std::vector<float>& srgb);
// Display-referred value from which a channel of a photo counts as clipped: code 249 of 255, since JPEG compression and
// resampling lower clipped pixels by a few codes.
inline constexpr float kClippedSrgb = 249.f / 255.f;
// A clipped channel is a lower bound of the radiance: a brighter prediction agrees with it and becomes the target. Both are
// planar [3,h,w], display-referred.
void raise_clipped(std::span<const float> prediction_srgb, std::span<float> target_srgb);

// Capture::near_z of these photos.
float near_plane(const ViewSet& view_set);
// Cameras, sparse points, near_z, and the training and held-out photos; no pictures.
Capture load_cameras(const std::filesystem::path& sfm_folder, int holdout_every);
Capture load_capture(const std::filesystem::path& sfm_folder, int max_side, int holdout_every);
// A part of a capture: the photos with wanted[view] != 0 and the sparse points that they see. Held-out photos and near_z stay
// those of the whole capture.
Capture load_part(const std::filesystem::path& sfm_folder, int max_side, int holdout_every, std::span<const uint8_t> wanted);
ViewSet part_of(const ViewSet& whole, std::span<const uint8_t> wanted);
// Memory of load_capture() in bytes, from the intrinsics alone.
size_t pyramid_bytes(const ViewSet& view_set, int max_side);

// Photos of one epoch, permuted by seed and epoch only: a resumed run need not store the order.
std::vector<uint32_t> photo_order(std::span<const uint32_t> photos, uint64_t seed, uint64_t epoch);

}  // namespace vitrine
