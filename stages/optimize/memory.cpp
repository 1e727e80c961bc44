#include "stages/optimize/optimize.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/learn/trainer/capture.h"
#include "core/scene/camera/mask_class.h"
#include "stages/optimize/blocks.h"
#include "stages/optimize/plane_inpainting.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

// Measured: parameters, gradient and two moments of a surfel (4 x 28 floats at degree 1), statistics, projected surfel and tile
// entries; channels, gradients and loss maps of a pixel.
constexpr size_t kBytesPerSurfel = 1600, kBytesPerPixel = 320, kBytesOfProgram = 150u << 20;
constexpr size_t kBytesPerTwinSurfel = 224;  // its parameters, in training and in the outputs
// Bytes per pyramid pixel: three colours of a photo, a mask, three components of a normal and its confidence.
constexpr size_t kPhotoBytes = 6, kMaskBytes = 1, kNormalBytes = 7;

}  // namespace

size_t bytes_before_surfels(const ViewSet& views, int max_side, const std::optional<fs::path>& masks,
                            const std::optional<fs::path>& normals) {
  size_t largest = 0;
  for (const View& view : views.views) {
    const Intrinsics k = view.intrinsics.limited_to(max_side);
    largest = std::max(largest, k.pixel_count());
  }
  const size_t photos = pyramid_bytes(views, max_side), pixels = photos / kPhotoBytes;
  size_t bytes = kBytesOfProgram + photos + kBytesPerPixel * largest;
  std::error_code none;
  for (MaskClass mask : kMaskClasses)
    if (masks && fs::is_directory(*masks / "masks" / name(mask), none)) bytes += kMaskBytes * pixels;
  if (normals && fs::is_directory(*normals / "normals", none)) bytes += kNormalBytes * pixels;
  return bytes;
}

size_t affordable_surfels(const OptimizeConfig& config, size_t bytes_before, size_t max_memory_bytes) {
  const size_t trained =
      kBytesPerSurfel + (config.opaque_twin && config.layers != WantedLayers::Diffuse ? kBytesPerTwinSurfel : 0);
  const auto each = config.fill_unseen ? static_cast<size_t>((1 + kMostUnseen) * double(trained)) : trained;
  return max_memory_bytes > bytes_before ? (max_memory_bytes - bytes_before) / each : 0;
}

namespace {

// Largest max_gaussians of a run for which one training, or the one of every block, fits.
size_t possible_surfels(const OptimizeConfig& config, size_t max_memory_bytes, const fs::path& sfm,
                        const std::optional<fs::path>& masks, const std::optional<fs::path>& normals) {
  const auto affordable = [&](const ViewSet& views) {
    return affordable_surfels(config, bytes_before_surfels(views, config.max_side, masks, normals), max_memory_bytes);
  };
  if (config.blocks <= 1) return affordable(load_view_set(sfm));
  const Capture cameras = load_cameras(sfm, config.holdout_every);
  size_t least = SIZE_MAX;
  for (const Block& block : planned_blocks(cameras.view_set, cameras.train, config.blocks).blocks)
    least = std::min(least, static_cast<size_t>(double(affordable(part_of(cameras.view_set, block.photos))) / block.point_share));
  return least;
}

}  // namespace

std::vector<FittedOption> fit_into_memory(const OptimizeConfig& config, size_t max_memory_bytes, const InputPaths& inputs) {
  const auto path = [&](const char* input) {
    const auto found = inputs.find(input);
    return found == inputs.end() ? std::nullopt : std::optional<fs::path>(found->second);
  };
  const auto sfm = path("sfm");
  if (!sfm) return {};
  const auto wanted = static_cast<size_t>(config.max_gaussians);
  const size_t possible = possible_surfels(config, max_memory_bytes, *sfm, path("masks"), path("normals"));
  if (possible >= wanted) return {};
  const size_t taken = std::max(possible, std::min(kFewestSurfels, wanted));
  return {
      {.path = "max_gaussians",
       .value = std::to_string(taken),
       .code = "FEWER_SURFELS",
       .text = fmt::format("the memory limit of {} MiB allows {} surfels instead of {}", max_memory_bytes >> 20, taken, wanted)}};
}

StageFit optimize_fit() {
  return [](const Stage& stage, size_t max_memory_bytes, const InputPaths& inputs) {
    return fit_into_memory(*static_cast<const OptimizeConfig*>(stage.config.get()), max_memory_bytes, inputs);
  };
}

}  // namespace vitrine
