// View sets: those of the sfm stage (reads and writes sparse/0 in COLMAP format, transforms.json, scene.json and gains.json), and
// their split into training and held-out views.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/transforms_file.h"
#include "core/scene/camera/view.h"

namespace vitrine {

// From an sfm artifact folder (sparse/0/*.bin + sfm/gains.json + scene.json). Throws Error{Input} with file and cause.
ViewSet load_view_set(const std::filesystem::path& sfm_folder);
// Path of the undistorted linear EXR of a view in an sfm artifact: linear/<stem>.exr.
std::filesystem::path linear_image_path(const std::filesystem::path& sfm_folder, const View& view);

// Reads a transforms.json (core/scene/camera/transforms_file.h) as undistorted views, sorted by name. Names are relative to the
// folder "images" or to the deepest common folder of all frames. Throws for lens distortion, and for frames without w and h for
// which `size_of` returns no size.
using SizeOfView = std::function<std::optional<PictureSize>(const std::string& name)>;
std::vector<View> read_transforms_json(const std::filesystem::path& path, const SizeOfView& size_of = {});
void write_transforms_json(const std::filesystem::path& path, const std::vector<View>& views, const std::string& image_folder);

// Training split, optimize/views.json: training views, held-out views, image size in training.
struct ViewSplit {
  int holdout_every = 0;
  int max_side = 0;                    // longest side in training, pixels; 0 = full size
  std::vector<size_t> train, heldout;  // indices into the views
  bool object_alone = false;           // trained inside the object masks only: the scene contains the object alone
};
// Throws Error{Input} if the file is invalid or names a view that is not in the capture.
ViewSplit read_view_split(const std::filesystem::path& path, const std::vector<View>& views);
// Selected `views` at their training size.
std::vector<View> at_trained_size(const std::vector<View>& views, const std::vector<size_t>& indices, const ViewSplit& split);

}  // namespace vitrine
