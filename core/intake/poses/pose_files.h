// Locates camera poses in a user's path: the layouts of COLMAP, nerfstudio, instant-ngp, Blender, 3D Gaussian splatting and
// OpenMVS, files of Metashape, OpenSfM and OpenMVG, or a folder of projection matrices.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/foundation/config/photo_name_finder.h"
#include "core/intake/photos/photo_list.h"

namespace vitrine {

struct PoseFile {
  enum class Kind { Colmap, Transforms, Matrices, Metashape, OpenSfm, OpenMvg };
  Kind kind = Kind::Colmap;
  std::filesystem::path path;                      // the folder of a COLMAP model; a JSON or XML file; the folder of the matrices
  std::vector<std::filesystem::path> joined = {};  // JSON files whose frames follow: the other parts of a split data set
};

// A file of poses by its content, whatever it is called.
struct RecognisedPoses {
  std::optional<PoseFile::Kind> kind;  // that is read; empty: `what` it is instead
  std::string what;                    // "a Meshroom scene"
  std::string hint;                    // what to give instead; empty: nothing in particular
};
// JSON with mistakes counts as a transforms.json, whose reader reports them.
RecognisedPoses recognised_poses(const std::filesystem::path& file);

// All candidates in `path` (file or folder), the most common first; never empty. transforms_train.json, _val and _test of a
// folder without transforms.json are candidates alone, and the last one together. Throws Error{Input} when there are none; the
// error names the format of unsupported files.
std::vector<PoseFile> find_pose_files(const std::filesystem::path& path);

// Maps a file of a COLMAP model (images.txt, cameras.bin, ..) to its folder; returns all other paths unchanged.
std::filesystem::path meant_poses(const std::filesystem::path& path);

// Folders that picture names in the file may be relative to, the likeliest first.
std::vector<std::filesystem::path> picture_folders(const PoseFile& file);

// P/*.txt, or the *.txt and *.P of the folder itself; sorted.
std::vector<std::filesystem::path> matrix_files(const std::filesystem::path& folder);

// Finds the photos of a capture by the names used in external files (core/foundation/config/photo_name_finder.h).

// Photos are found by their path below the user's photo folder and by their own name.
class PhotoFinder : public PhotoNameFinder {
 public:
  explicit PhotoFinder(std::span<const Photo> photos);
};

// Groups photos that are versions of one picture, as data sets store them: "images_2/a.jpg" has half the size of
// "images/a.jpg", and 3D Gaussian splatting's script undistorts "input/a.jpg" into "images/a.jpg". Per photo: the first of its
// versions, possibly itself.
std::vector<size_t> first_versions(std::span<const Photo> photos);

}  // namespace vitrine
