// Binary and text formats of COLMAP models, for colmap_model.cpp only. The readers check syntax; check_colmap_model checks
// semantics.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/scene/camera/colmap_model.h"

namespace vitrine::colmap {

// Syntax error with its byte or line; the caller adds the file name.
struct Malformed {
  std::string why;
};

std::vector<ColmapCamera> cameras_from_binary(std::string_view bytes);
std::vector<ColmapImage> images_from_binary(std::string_view bytes);
std::vector<ColmapPoint3D> points_from_binary(std::string_view bytes);
std::string binary_of(const std::vector<ColmapCamera>& cameras);
std::string binary_of(const std::vector<ColmapImage>& images);
std::string binary_of(const std::vector<ColmapPoint3D>& points);

std::vector<ColmapCamera> cameras_from_text(std::string_view text);
std::vector<ColmapImage> images_from_text(std::string_view text);
std::vector<ColmapPoint3D> points_from_text(std::string_view text);
std::string text_of(const std::vector<ColmapCamera>& cameras);
std::string text_of(const std::vector<ColmapImage>& images);
std::string text_of(const std::vector<ColmapPoint3D>& points);

// --- rigs and frames (COLMAP 3.12 and later) ----------------------------------------------------------------------------
struct Sensor {
  bool is_camera = true;  // else an IMU or another sensor without images
  uint32_t id = 0;        // of a camera: its camera id
  bool has_pose = true;   // sensor_from_rig; the identity for the reference sensor
  Quatd rotation = {1, 0, 0, 0};
  Vec3d translation = {};
};
struct Rig {
  uint32_t id = 0;
  std::vector<Sensor> sensors;  // the reference sensor first
};
struct FrameImage {
  uint32_t camera_id = 0;
  uint64_t image_id = 0;
};
// A rig at one time.
struct Frame {
  uint32_t id = 0, rig_id = 0;
  Quatd rotation = {1, 0, 0, 0};  // rig_from_world
  Vec3d translation = {};
  std::vector<FrameImage> images;
};

std::vector<Rig> rigs_from_binary(std::string_view bytes);
std::vector<Frame> frames_from_binary(std::string_view bytes);
std::vector<Rig> rigs_from_text(std::string_view text);
std::vector<Frame> frames_from_text(std::string_view text);

// True if the images have no poses: zeros, no numbers, or one pose for all.
bool lack_poses(const std::vector<ColmapImage>& images);
// Gives images that lack a pose that of their frame, sensor_from_rig * rig_from_world. Images with poses keep them; a warning
// follows if the frames contradict. Throws Malformed for rigs and frames without a pose that is needed.
void take_poses_of_frames(std::vector<ColmapImage>& images, const std::vector<Rig>& rigs, const std::vector<Frame>& frames);

// Throws Malformed for unsupported models.
const ColmapCameraType& known_camera_type(int model_id);
const ColmapCameraType& known_camera_type(std::string_view name);

}  // namespace vitrine::colmap
