// Shape sets in files: a list in a JSON document; meshes as shape_<entry>.ply beside it, or wherever the caller keeps them.
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

// An entry of the list that is no shape.
struct ShapeMistake : std::domain_error {
  ShapeMistake(size_t number, const std::string& why);
  size_t entry;
};

// Throws ShapeMistake; nlohmann's exceptions if the document is no list; what reading a mesh throws.
ShapeSet read_shapes(const nlohmann::json& json, const MeshSource& mesh);
ShapeSet read_shapes(const nlohmann::json& json, const std::filesystem::path& folder);

}  // namespace vitrine
