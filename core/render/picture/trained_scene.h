// A trained scene: gaussians/<layer>.ply, gaussians/opaque.ply and optimize/model.json (the image-formation options used in
// training). refine/gaussians/<layer>.ply and refine/model.json replace them where the refine stage wrote a better scene; the
// opaque twin stays. The diffuse layer is required; a layer without a file is empty.
#pragma once

#include <filesystem>
#include <optional>

#include "core/render/model/image_options.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

struct TrainedScene {
  SplatScene surfels;
  ImageOptions image;  // backends and ray budgets keep their defaults: they belong to the machine and the run
};

// `optimize`, `refine`: artifacts of these stages. A refine artifact that left the scene unchanged contains none. Throws
// Error{Input} with file and cause.
TrainedScene read_trained_scene(const std::filesystem::path& optimize,
                                const std::optional<std::filesystem::path>& refine = std::nullopt);

// Writes the options that affect pictures of the scene: blend, lobe, ray start and end, known shapes, the
// medium in front of the cameras. Meshes of shapes and of
// thick glass are written as PLY next to the file.
void write_image_options(const std::filesystem::path& path, const ImageOptions& options);
// Returns the defaults if there is no file (a scene with only a diffuse layer depends on none of them).
ImageOptions read_image_options(const std::filesystem::path& path);

}  // namespace vitrine
