// Scene files: one binary PLY per layer with the raw values of every attribute row, bit-exact round trip. Object ids, if known,
// are the last property, object_id.
#pragma once

#include <filesystem>

#include "core/scene/surfels/layers.h"

namespace vitrine {

void write_layer(const std::filesystem::path& path, const SplatLayer& layer);
// Throws Error{Input} with file and cause (truncated, unknown layer, wrong property, non-finite value, absurd count).
SplatLayer read_layer(const std::filesystem::path& path);

}  // namespace vitrine
