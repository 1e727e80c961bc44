// Depth maps that users bring with their photos: one file per photo, from a sensor, a renderer or a network.
//
//   depth/b.png          ScanNet, Polycam, Record3D: 16 bit, millimetres
//   b_depth.png, depth_b.exr, frame_7.depth.png next to frame_7.color.jpg: names of core/intake/photos/picture_roles.h
//   depth_file_path, depth_path of a transforms.json (nerfstudio, instant-ngp), in units of depth_unit_scale_factor or
//   integer_depth_scale
//
// Values are z-depths along the axis of the camera. 0, NaN, infinity and the largest value of the format mean unknown.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/scene/image/image.h"

namespace vitrine {

inline constexpr double kDepthUnit = 0.001;  // metres of an integer step, as sensors write it

class DepthFolder {
 public:
  // `path`: a folder of depth maps, the folder of the photos, or a transforms.json (also in the folder). Throws Error{Input}.
  explicit DepthFolder(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  size_t file_count() const { return files_; }
  double unit() const { return unit_; }                                         // metres of an integer step
  const std::vector<std::filesystem::path>& listed() const { return listed_; }  // maps that a list names
  // The map of each photo, by its name "left/b.jpg". Throws Error{Input}: two files match one photo, or no photo has one.
  std::vector<std::optional<std::filesystem::path>> match(std::span<const std::string> photos) const;

 private:
  struct Candidate {
    std::filesystem::path path;
    int rank = 0;  // lower is better: EXR, TIFF, PNG; with a word for depth, without
  };
  using Index = std::map<std::string, std::vector<Candidate>>;  // lower-case keys

  void add_transforms(const std::filesystem::path& json);
  void add_folder();
  // `relative`: the path that is compared with the photos' names.
  void add(const std::filesystem::path& file, const std::filesystem::path& relative);

  std::filesystem::path path_;
  size_t files_ = 0;
  double unit_ = kDepthUnit;
  Index by_path_, by_name_, by_words_;
  std::vector<std::string> listed_photos_;             // names in a list, and
  std::vector<std::filesystem::path> listed_, lists_;  // their maps; the folders of the lists
};

// The depth maps that a transforms.json given as depth refers to; empty for other paths and unreadable files.
std::vector<std::filesystem::path> files_of_depth_list(const std::filesystem::path& depth);

// [h,w,1] in metres, 0 = unknown. `unit`: metres of an integer step; floating-point files are in metres. Throws Error{Input}:
// unreadable, a picture with colours, 8 bits, constant, negative.
ImageF read_depth(const std::filesystem::path& file, double unit = kDepthUnit);

// Checks names before a run; returns a sentence on photos without a map. Throws as match().
std::vector<std::string> check_depth_names(const std::filesystem::path& depth, const std::vector<std::string>& photos);

// Equal aspect ratio within one percent: sensors and their colour cameras round differently (640 x 480 of 1296 x 968).
bool same_depth_shape(int width, int height, double photo_width, double photo_height);
[[noreturn]] void throw_wrong_depth_size(const std::filesystem::path& file, const ImageF& depth, int photo_width,
                                         int photo_height);

}  // namespace vitrine
