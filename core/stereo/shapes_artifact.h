// The file of known shapes that the shapes stage writes and people correct: shapes.json, a document with the list "shapes"
// (core/shape/shape_file.h) in the scene frame, and meshes beside it.
#pragma once

#include <filesystem>
#include <optional>

#include "core/shape/shape_set.h"

namespace vitrine {

// `file`: a shapes.json. Throws Error{Input} with line and column of the entry.
ShapeSet read_shapes_file(const std::filesystem::path& file);

// shapes/shapes.json of an artifact; an empty set where there is no artifact, or none in it.
ShapeSet read_shapes_artifact(const std::optional<std::filesystem::path>& artifact);

}  // namespace vitrine
