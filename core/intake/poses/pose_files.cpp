#include "core/intake/poses/pose_files.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <tuple>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/camera/colmap_model.h"

namespace vitrine {

namespace {

constexpr size_t kDeepest = 4;         // "colmap/dense/0/sparse"
constexpr size_t kMostFolders = 2000;  // visited at most: data sets have a few folders, a home folder very many
const std::array kUsual{"sparse/0",
                        "sparse",
                        "colmap/sparse/0",
                        "colmap/sparse",
                        "dense/sparse",
                        "dense/0/sparse",
                        "dense/0",
                        "undistorted/sparse/0",
                        "undistorted/sparse",
                        ".",
                        "0",
                        "colmap/0",
                        "colmap",
                        "distorted/sparse/0",
                        "distorted/sparse"};

std::vector<fs::path> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code ec;
  for (fs::directory_iterator at(folder, ec), end; !ec && at != end; at.increment(ec)) out.push_back(at->path());
  std::sort(out.begin(), out.end());
  return out;
}

// An output folder of this program: its cameras are those of undistorted photos, and it is not part of the surrounding capture.
bool is_own_output(const fs::path& folder) {
  std::error_code ec;
  return fs::exists(folder / "scene.json", ec) && fs::exists(folder / "sparse", ec) && fs::exists(folder / "linear", ec);
}

std::vector<fs::path> colmap_folders(const fs::path& root) {
  std::vector<fs::path> found, level{root};
  std::set<fs::path> seen;  // canonical paths, so that linked folders count once
  for (size_t depth = 0; depth <= kDeepest && !level.empty(); ++depth) {
    std::vector<fs::path> next;
    for (const fs::path& folder : level) {
      std::error_code ignored;
      if (seen.size() >= kMostFolders || !seen.insert(fs::weakly_canonical(folder, ignored)).second) continue;
      if (holds_colmap_model(folder)) found.push_back(folder);
      if (depth == kDeepest) continue;
      std::error_code ec;
      for (const fs::path& entry : sorted_entries(folder))
        if (fs::is_directory(entry, ec) && !entry.filename().native().starts_with('.') && !is_own_output(entry))
          next.push_back(entry);
    }
    level = std::move(next);
  }
  const auto rank = [&](const fs::path& folder) {
    const std::string relative = folder.lexically_relative(root).generic_string();
    const auto at = std::find(kUsual.begin(), kUsual.end(), relative);
    return std::tuple(at - kUsual.begin(), relative.size(), relative);
  };
  std::sort(found.begin(), found.end(), [&](const fs::path& a, const fs::path& b) { return rank(a) < rank(b); });
  return found;
}

std::vector<PoseFile> transforms_files(const fs::path& root) {
  std::vector<PoseFile> out;
  std::vector<fs::path> parts;
  std::error_code ec;
  const auto take = [&](const fs::path& file) {
    if (!fs::is_regular_file(file, ec) || std::ranges::find(out, file, &PoseFile::path) != out.end()) return false;
    out.push_back({PoseFile::Kind::Transforms, file});
    return true;
  };
  const bool whole = take(root / "transforms.json");
  for (const char* part : {"train", "val", "test"})
    if (const fs::path file = root / fmt::format("transforms_{}.json", part); take(file)) parts.push_back(file);
  for (const fs::path& entry : sorted_entries(root))
    if (const std::string name = entry.filename().string(); name.starts_with("transforms") && name.ends_with(".json"))
      take(entry);
  if (!whole && parts.size() > 1) out.push_back({PoseFile::Kind::Transforms, parts[0], {parts.begin() + 1, parts.end()}});
  return out;
}

// Files of other programs by their usual names; their content decides whether they are read.
std::vector<PoseFile> program_files(const fs::path& root) {
  std::vector<PoseFile> out;
  std::error_code ec;
  for (const fs::path& folder : {root, root / "opensfm"})
    for (const fs::path& entry : sorted_entries(folder)) {
      const std::string name = lowered(entry.filename().string()), extension = lowered(entry.extension().string());
      const bool usual =
          extension == ".xml" || (extension == ".json" && (name.starts_with("reconstruction") || name.starts_with("sfm_data")));
      if (!usual || !fs::is_regular_file(entry, ec)) continue;
      const auto kind = recognised_poses(entry).kind;
      if (kind && *kind != PoseFile::Kind::Transforms) out.push_back({*kind, entry});
    }
  return out;
}

// "; found cameras.sfm: a Meshroom scene": what lies in a folder without poses that are read.
std::string others_in(const fs::path& root) {
  std::error_code ec;
  for (const fs::path& entry : sorted_entries(root)) {
    const std::string extension = lowered(entry.extension().string());
    const bool likely = extension == ".xml" || extension == ".sfm" || extension == ".json" || extension == ".nvm" ||
                        extension == ".out" || extension == ".psx" || extension == ".npy" || extension == ".db";
    if (!likely || !fs::is_regular_file(entry, ec)) continue;
    const RecognisedPoses r = recognised_poses(entry);
    if (!r.kind) return fmt::format("; {} is {}", entry.filename().string(), r.what);
  }
  return {};
}

constexpr const char* kHint =
    "give a COLMAP model (cameras, images: .bin or .txt), a transforms.json, cameras of Metashape (XML), OpenSfM or OpenMVG "
    "(JSON), or a folder of 3x4 matrices (P/*.txt)";

[[noreturn]] void throw_missing(const fs::path& path, std::string why, std::string hint = kHint) {
  throw Error(ErrorKind::Input, "no camera poses found",
              {.where = path.string(), .why = std::move(why), .hint = std::move(hint), .code = "POSES_MISSING"});
}

}  // namespace

fs::path meant_poses(const fs::path& path) {
  const std::string extension = path.extension().string(), stem = path.stem().string();
  std::error_code ec;
  const bool part = (extension == ".txt" || extension == ".bin") &&
                    (stem == "cameras" || stem == "images" || stem == "points3D" || stem == "rigs" || stem == "frames");
  return part && fs::is_regular_file(path, ec) ? path.parent_path() : path;
}

std::vector<fs::path> matrix_files(const fs::path& folder) {
  for (const fs::path& place : {folder / "P", folder}) {
    std::vector<fs::path> out;
    std::error_code ec;
    for (const fs::path& entry : sorted_entries(place))
      if ((entry.extension() == ".txt" || entry.extension() == ".P") && fs::is_regular_file(entry, ec)) out.push_back(entry);
    if (!out.empty()) return out;
  }
  return {};
}

std::vector<PoseFile> find_pose_files(const fs::path& given) {
  const fs::path path = meant_poses(given);
  std::error_code ec;
  if (path != given && !holds_colmap_model(path)) {
    const fs::path missing = path / (given.stem() == "images" ? "cameras" : "images");
    throw_missing(given, fmt::format("it belongs to a COLMAP model, and {}.bin or .txt is not next to it", missing.string()));
  }
  if (fs::is_regular_file(path, ec)) {
    const RecognisedPoses r = recognised_poses(path);
    if (!r.kind) throw_missing(path, "this is " + r.what, r.hint.empty() ? kHint : r.hint);
    return {{*r.kind, path}};
  }
  std::vector<PoseFile> found;
  for (const fs::path& folder : colmap_folders(path)) found.push_back({PoseFile::Kind::Colmap, folder});
  for (PoseFile& file : transforms_files(path)) found.push_back(std::move(file));
  for (PoseFile& file : program_files(path)) found.push_back(std::move(file));
  if (found.empty() && !matrix_files(path).empty()) found.push_back({PoseFile::Kind::Matrices, path});
  if (found.empty())
    throw_missing(
        path,
        "neither a COLMAP model (cameras, images: .bin or .txt), nor transforms.json, nor cameras of Metashape, OpenSfM or "
        "OpenMVG, nor 3x4 matrices (P/*.txt)" +
            others_in(path),
        "give one of these with --poses");
  return found;
}

std::vector<fs::path> picture_folders(const PoseFile& file) {
  std::vector<fs::path> out;
  if (file.kind == PoseFile::Kind::Matrices) return out;
  if (file.kind != PoseFile::Kind::Colmap) return {file.path.parent_path()};
  std::error_code ec;
  fs::path up = fs::absolute(file.path, ec).lexically_normal();
  if (!up.has_filename()) up = up.parent_path();
  const bool distorted = std::find(up.begin(), up.end(), "distorted") != up.end();
  for (size_t i = 0; i < kDeepest; ++i) {
    for (const char* name : {distorted ? "input" : "images", distorted ? "images" : "input", ""}) out.push_back(up / name);
    if (up == up.parent_path()) break;
    up = up.parent_path();
  }
  return out;
}

}  // namespace vitrine
