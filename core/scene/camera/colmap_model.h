// COLMAP models in memory (cameras, images with their 2D points, 3D points with their tracks) and their binary and text files
// (core/conventions.md; layouts in colmap_binary.cpp and colmap_text.cpp). Pixel centres at .5, poses are cam_from_world.
//
// Damaged, truncated or inconsistent files throw Error{Input} with the file and the cause. Counts are checked against the file
// size before allocation, so a wrong byte cannot allocate terabytes.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/foundation/math/rigid.h"

namespace vitrine {

constexpr uint64_t kNoPoint3D = ~uint64_t{0};  // 2D point without a 3D point

// COLMAP camera model: name, id, number of parameters.
struct ColmapCameraType {
  int id;
  std::string_view name;
  size_t parameter_count;
  std::string_view since;  // first COLMAP version that writes it
};
// nullptr when unknown.
const ColmapCameraType* colmap_camera_type(int model_id);
const ColmapCameraType* colmap_camera_type(std::string_view name);

struct ColmapCamera {
  uint32_t id = 0;
  int model_id = 1;  // 1 = PINHOLE
  uint64_t width = 0, height = 0;
  std::vector<double> params;  // [parameter_count], in COLMAP's order
  bool operator==(const ColmapCamera&) const = default;
};

struct ColmapPoint2D {
  double x = 0, y = 0;
  uint64_t point3d_id = kNoPoint3D;
  bool operator==(const ColmapPoint2D&) const = default;
};

struct ColmapImage {
  uint32_t id = 0;
  Quatd rotation;  // cam_from_world, as in the file (possibly not exactly unit)
  Vec3d translation;
  uint32_t camera_id = 0;
  std::string name;  // relative to the image folder
  std::vector<ColmapPoint2D> points;

  Rigid cam_from_world() const { return {rotation_matrix(normalized(rotation)), translation}; }
  bool operator==(const ColmapImage&) const = default;
};

struct ColmapTrackElement {
  uint32_t image_id = 0, point2d_index = 0;
  bool operator==(const ColmapTrackElement&) const = default;
};

struct ColmapPoint3D {
  uint64_t id = 0;
  Vec3d position;
  std::array<uint8_t, 3> srgb{};
  double error_px = 0;
  std::vector<ColmapTrackElement> track;
  bool operator==(const ColmapPoint3D&) const = default;
};

struct ColmapModel {
  std::vector<ColmapCamera> cameras;  // each list sorted by id, ids unique
  std::vector<ColmapImage> images;
  std::vector<ColmapPoint3D> points;

  const ColmapCamera* find_camera(uint32_t id) const;  // by binary search; nullptr when absent
  const ColmapImage* find_image(uint32_t id) const;
  const ColmapPoint3D* find_point(uint64_t id) const;
  bool operator==(const ColmapModel&) const = default;
};

// --- files ----------------------------------------------------------------------------------------------------------
enum class ColmapFormat { Binary, Text };

// Model folder written by vitrine: `root`/sparse/0, `root`/sparse, `root`/dense/sparse, or `root` itself, in this order. For
// models of other programs see pose_files.h.
std::optional<std::filesystem::path> find_colmap_model(const std::filesystem::path& root);
// True if cameras and images exist in either format.
bool holds_colmap_model(const std::filesystem::path& folder);
// Reads and checks the model of exactly this folder (.bin preferred). points3D is optional (poses only). A part that exists
// only in the other format is read from that.
ColmapModel read_colmap_model(const std::filesystem::path& folder);
ColmapModel read_colmap_model(const std::filesystem::path& folder, ColmapFormat preferred);
// Sorted by id, otherwise unchecked: for models of other programs, which colmap_repair.h repairs.
ColmapModel read_colmap_parts(const std::filesystem::path& folder);
ColmapModel read_colmap_parts(const std::filesystem::path& folder, ColmapFormat preferred);
// Three files, each written atomically. Numbers in text files round-trip exactly.
void write_colmap_model(const std::filesystem::path& folder, const ColmapModel& model, ColmapFormat format);
// Throws Error{Input} if an id occurs twice.
void sort_by_ids(ColmapModel& model, const std::filesystem::path& where);
// Sorts the lists and checks the invariants: unique ids, valid references, finite poses, plausible sizes, unique image names
// inside their folder (not checked with Any). Throws Error{Input} with `where` as the place. Called by the readers.
enum class ColmapNames { Inside, Any };
void check_colmap_model(ColmapModel& model, const std::filesystem::path& where, ColmapNames names = ColmapNames::Inside);

// Transforms points and poses.
void transform_world(ColmapModel& model, const Similarity& new_from_old);

// --- cameras --------------------------------------------------------------------------------------------------------
// Pixel of the camera-frame direction (x, y, 1). Supported: SIMPLE_PINHOLE to FULL_OPENCV, FOV, fisheye up to
// THIN_PRISM_FISHEYE. Other models throw Error{Input} here, at use; colmap_lens.h reduces models whose further parameters are zero.
Vec2d project(const ColmapCamera& camera, const Vec2d& direction);
// Inverse of project(): (x, y) of the direction (x, y, 1) at a pixel; nullopt where the distortion cannot be inverted.
std::optional<Vec2d> unproject(const ColmapCamera& camera, const Vec2d& pixel);
// Focal lengths, principal point and size, ignoring distortion.
Intrinsics pinhole_part(const ColmapCamera& camera);
bool is_distorted(const ColmapCamera& camera);
ColmapCamera colmap_pinhole(uint32_t id, const Intrinsics& intrinsics);

}  // namespace vitrine
