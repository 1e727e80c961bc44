// Shape set files: a list in a JSON document; meshes as shape_<entry>.ply next to it, or wherever the caller stores them.
//   {"kind": "box", "role": "sheet", "tolerance": 0.02, "parent": 3, "clear": [1, 1, ...], "exact": false, "object": 2, ... the
//   kind's numbers (registry.h)}
#pragma once

#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/scene/shape/shape_set.h"

namespace vitrine {

using MeshSink = std::function<void(size_t entry, const TriMesh&)>;
using MeshSource = std::function<TriMesh(size_t entry)>;

nlohmann::ordered_json write_shapes(const ShapeSet& set, const MeshSink& mesh);
nlohmann::ordered_json write_shapes(const ShapeSet& set, const std::filesystem::path& folder);

// Invalid entry of the list.
struct ShapeMistake : std::domain_error {
  ShapeMistake(size_t number, const std::string& why);
  size_t entry;
};

// Throws ShapeMistake, nlohmann exceptions if the document is not a list, and exceptions of the mesh reader.
ShapeSet read_shapes(const nlohmann::json& json, const MeshSource& mesh);
ShapeSet read_shapes(const nlohmann::json& json, const std::filesystem::path& folder);

}  // namespace vitrine
