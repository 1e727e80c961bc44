// Shape set files: a list in a JSON document; meshes as shape_<entry>.ply next to it, or wherever the caller stores them.
//   {"kind": "box", "role": "sheet", "tolerance": 0.02, "parent": 3, "clear": [1, 1, ...], "exact": false, "object": 2, ... the
//   kind's numbers (below)}
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "core/foundation/base/rng.h"
#include "core/scene/shape/shape.h"
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

// Registry of shape kinds, one row each: file format and test data. To add a kind, add an alternative to Shape and a row;
// tests/core/scene/shape tests every row.
struct ShapeKind {
  std::string_view name;  // in files
  // Writes the parameters. If `mesh` is not nullptr, the mesh it returns is stored in a separate file.
  nlohmann::ordered_json (*write)(const Shape&);
  const TriMesh* (*mesh)(const Shape&);
  // nullopt or nlohmann exceptions if the values are not a valid shape.
  std::optional<Shape> (*read)(const nlohmann::json&, TriMesh mesh);
  Shape (*sample)(Rng&);  // random shape, size about 1, near the origin
  double precision;       // of intersections
  double gradient_error;  // relative error of hit_vjp due to neglected terms
};

std::span<const ShapeKind> shape_kinds();  // [Shape::index()]
inline const ShapeKind& kind_of(const Shape& shape) { return shape_kinds()[shape.index()]; }
const ShapeKind* find_shape_kind(std::string_view name);

}  // namespace vitrine
