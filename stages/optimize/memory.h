// What training takes of memory, from cameras and file names alone: known before anything is read, so that under --max-memory the
// number of surfels is an option of the run, part of its key, and not something that is found out on the way.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/scene/camera/view_set.h"
#include "stages/optimize/optimize.h"
#include "stages/stage_fit.h"

namespace vitrine {

inline constexpr size_t kFewestSurfels = 2000;  // fewer are no scene

// Photos, masks and normals of all views, and the images of one step: what is there before the first surfel.
size_t bytes_before_surfels(const ViewSet& views, int max_side, const std::optional<std::filesystem::path>& masks,
                            const std::optional<std::filesystem::path>& normals);
// As many surfels as fit beside that, those for what no photo shows among them.
size_t affordable_surfels(const OptimizeConfig& config, size_t bytes_before, size_t max_memory_bytes);
// max_gaussians, where fewer fit than are wanted.
std::vector<FittedOption> fit_into_memory(const OptimizeConfig& config, size_t max_memory_bytes, const InputPaths& inputs);
StageFit optimize_fit();

}  // namespace vitrine
