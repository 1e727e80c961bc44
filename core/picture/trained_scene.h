// A trained scene as the optimize stage left it: gaussians/<layer>.ply, gaussians/opaque.ply and optimize/model.json, the options
// of the image formation that it was trained with. Where the refine stage has a better one, that: refine/gaussians/<layer>.ply
// and refine/model.json; the opaque twin stays. The diffuse layer is always there; a layer without a file is empty and takes no
// part.
#pragma once

#include <filesystem>
#include <optional>

#include "core/model/image_options.h"
#include "core/scene/splat_scene.h"

namespace vitrine {

struct TrainedScene {
  SplatScene surfels;
  ImageOptions image;  // backends and budgets are the machine's and the run's, not the scene's: left at their defaults
};

// `optimize`, `refine`: artifacts of these stages; one of refine that kept the scene as it was has none of its own. Throws
// Error{Input} with file and cause.
TrainedScene read_trained_scene(const std::filesystem::path& optimize,
                                const std::optional<std::filesystem::path>& refine = std::nullopt);

// What of the options a picture of the scene depends on: blend, lobe, where rays start and end, and known shapes; meshes
// of shapes and of thick glass as PLY beside the file.
void write_image_options(const std::filesystem::path& path, const ImageOptions& options);
// Without a file: the defaults (scenes with a diffuse layer alone depend on none of it).
ImageOptions read_image_options(const std::filesystem::path& path);

}  // namespace vitrine
