// Where camera poses lie in what the user names: the layouts of COLMAP, nerfstudio, instant-ngp, Blender, 3D Gaussian splatting
// and OpenMVS, or a folder of projection matrices.
#pragma once

#include <filesystem>
#include <vector>

namespace vitrine {

struct PoseFile {
  enum class Kind { Colmap, Transforms, Matrices };
  Kind kind = Kind::Colmap;
  std::filesystem::path path;  // the folder of a COLMAP model; a JSON file; the folder of the matrices
};

// All that `path` (file or folder) may mean, the most usual first; never empty. Throws Error{Input} when there is none, and names
// the format of files that are not read.
std::vector<PoseFile> find_pose_files(const std::filesystem::path& path);

// A file of a COLMAP model (images.txt, cameras.bin, ..) means its folder; everything else means itself.
std::filesystem::path meant_poses(const std::filesystem::path& path);

// Where the pictures of such a file should lie: names in it are relative to these folders. The likeliest first.
std::vector<std::filesystem::path> picture_folders(const PoseFile& file);

// P/*.txt, or the *.txt and *.P of the folder itself; sorted.
std::vector<std::filesystem::path> matrix_files(const std::filesystem::path& folder);

}  // namespace vitrine
