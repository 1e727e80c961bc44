// Locates camera poses in a user's path: the layouts of COLMAP, nerfstudio, instant-ngp, Blender, 3D Gaussian splatting and
// OpenMVS, or a folder of projection matrices.
#pragma once

#include <filesystem>
#include <vector>

namespace vitrine {

struct PoseFile {
  enum class Kind { Colmap, Transforms, Matrices };
  Kind kind = Kind::Colmap;
  std::filesystem::path path;  // the folder of a COLMAP model; a JSON file; the folder of the matrices
};

// All candidates in `path` (file or folder), the most common first; never empty. Throws Error{Input} when there are none; the
// error names the format of unsupported files.
std::vector<PoseFile> find_pose_files(const std::filesystem::path& path);

// Maps a file of a COLMAP model (images.txt, cameras.bin, ..) to its folder; returns all other paths unchanged.
std::filesystem::path meant_poses(const std::filesystem::path& path);

// Folders that picture names in the file may be relative to, the likeliest first.
std::vector<std::filesystem::path> picture_folders(const PoseFile& file);

// P/*.txt, or the *.txt and *.P of the folder itself; sorted.
std::vector<std::filesystem::path> matrix_files(const std::filesystem::path& folder);

}  // namespace vitrine
