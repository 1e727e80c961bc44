// Poses of images by the rigs and frames of COLMAP 3.12 and later (COLMAP: doc/format.rst, doc/rigs.rst):
//   cam_from_world of an image = sensor_from_rig of its camera * rig_from_world of its frame
// COLMAP writes the same poses into images.bin, where other programs look for them.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "core/foundation/base/log.h"
#include "core/scene/camera/colmap_files.h"

namespace vitrine::colmap {

namespace {

bool is_rigid(const Quatd& q, const Vec3d& t) {
  const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return std::isfinite(norm2) && norm2 > 1e-12 && std::isfinite(t.x) && std::isfinite(t.y) && std::isfinite(t.z);
}

// One pose for all images is what programs write that have the poses in the frames.
bool share_one_pose(const std::vector<ColmapImage>& images) {
  return images.size() > 1 && std::all_of(images.begin(), images.end(), [&](const ColmapImage& image) {
           return image.rotation == images[0].rotation && image.translation == images[0].translation;
         });
}

// sensor_from_rig; throws Malformed if it is unknown.
Rigid sensor_pose(const std::map<uint32_t, const Rig*>& rigs, const Frame& frame, const FrameImage& image) {
  const auto rig = rigs.find(frame.rig_id);
  if (rig == rigs.end()) {
    if (frame.images.size() == 1) return {};  // the only camera is the rig
    throw Malformed{fmt::format("frame {} uses rig {}, which is not in the model", frame.id, frame.rig_id)};
  }
  for (const Sensor& sensor : rig->second->sensors) {
    if (!sensor.is_camera || sensor.id != image.camera_id) continue;
    if (!sensor.has_pose || !is_rigid(sensor.rotation, sensor.translation))
      throw Malformed{fmt::format("rig {} has no pose of camera {}", frame.rig_id, image.camera_id)};
    return {rotation_matrix(normalized(sensor.rotation)), sensor.translation};
  }
  throw Malformed{fmt::format("rig {} has no camera {}, which frame {} uses", frame.rig_id, image.camera_id, frame.id)};
}

bool differ(const Rigid& a, const Rigid& b, double tolerance) {
  constexpr double kAngle = 0.1 * std::numbers::pi / 180;
  const Mat3d turn = a.rotation * transposed(b.rotation);
  const double cosine = (turn(0, 0) + turn(1, 1) + turn(2, 2) - 1) / 2;
  return std::acos(std::clamp(cosine, -1.0, 1.0)) > kAngle || length(inverse(a).translation - inverse(b).translation) > tolerance;
}

// Warns of images whose own pose is another than that of their frame.
void warn_of_contradictions(const std::vector<ColmapImage>& images, const std::map<uint64_t, Rigid>& by_frame) {
  double extent = 0;
  for (const ColmapImage& image : images)
    extent =
        std::max(extent, length(inverse(image.cam_from_world()).translation - inverse(images[0].cam_from_world()).translation));
  const size_t others = size_t(std::count_if(images.begin(), images.end(), [&](const ColmapImage& image) {
    const auto at = by_frame.find(image.id);
    return at != by_frame.end() && differ(image.cam_from_world(), at->second, 1e-3 * extent);
  }));
  if (others > 0)
    log_warning(
        "{} of {} images have other poses in the frames of the model: those of the images are used; to use the frames, "
        "write the model again with colmap model_converter",
        others, images.size());
}

}  // namespace

bool lack_poses(const std::vector<ColmapImage>& images) {
  return share_one_pose(images) || std::any_of(images.begin(), images.end(), [](const ColmapImage& image) {
           return !is_rigid(image.rotation, image.translation);
         });
}

void take_poses_of_frames(std::vector<ColmapImage>& images, const std::vector<Rig>& rigs, const std::vector<Frame>& frames) {
  const bool needed = lack_poses(images), all = share_one_pose(images);
  std::map<uint32_t, const Rig*> rig_of;
  for (const Rig& rig : rigs)
    if (!rig_of.emplace(rig.id, &rig).second) throw Malformed{fmt::format("rig {} occurs twice", rig.id)};
  std::map<uint64_t, Rigid> by_frame;
  for (const Frame& frame : frames)
    for (const FrameImage& image : frame.images) {
      if (!is_rigid(frame.rotation, frame.translation))
        throw Malformed{fmt::format("the pose of frame {} is not a rigid motion", frame.id)};
      const Rigid pose =
          sensor_pose(rig_of, frame, image) * Rigid{rotation_matrix(normalized(frame.rotation)), frame.translation};
      if (!by_frame.emplace(image.image_id, pose).second)
        throw Malformed{fmt::format("image {} is in two frames", image.image_id)};
    }
  if (!needed) return warn_of_contradictions(images, by_frame);
  size_t taken = 0;
  for (ColmapImage& image : images) {
    const bool rigid = is_rigid(image.rotation, image.translation);
    if (rigid && !all) continue;
    const auto at = by_frame.find(image.id);
    if (at == by_frame.end()) {
      if (rigid) continue;
      throw Malformed{fmt::format("image {} ('{}') has no pose, and no frame has it", image.id, image.name)};
    }
    image.rotation = quaternion(at->second.rotation);
    image.translation = at->second.translation;
    ++taken;
  }
  if (taken > 0) log_info("the poses of {} of {} images are those of their frames and rigs", taken, images.size());
}

}  // namespace vitrine::colmap
