// Memory estimate of training from cameras and file names, before any image is read. With --max-memory the number of surfels is
// therefore an option of the run and part of its cache key.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/scene/camera/view_set.h"
#include "stages/optimize/optimize.h"
#include "stages/stage_fit.h"

namespace vitrine {

inline constexpr size_t kFewestSurfels = 2000;  // smallest usable scene

// Bytes of the photos, masks and normals of all views, and of the images of one step.
size_t bytes_before_surfels(const ViewSet& views, int max_side, const std::optional<std::filesystem::path>& masks,
                            const std::optional<std::filesystem::path>& normals);
// Largest number of surfels that fits in the remaining memory, including those for unobserved regions.
size_t affordable_surfels(const OptimizeConfig& config, size_t bytes_before, size_t max_memory_bytes);
// Reduces max_gaussians if the wanted number does not fit.
std::vector<FittedOption> fit_into_memory(const OptimizeConfig& config, size_t max_memory_bytes, const InputPaths& inputs);
StageFit optimize_fit();

}  // namespace vitrine
