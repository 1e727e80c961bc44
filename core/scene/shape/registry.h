// Registry of shape kinds, one row each: file format and test data. To add a kind, add an alternative to Shape and a row;
// tests/core/scene/shape tests every row.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "core/foundation/base/rng.h"
#include "core/scene/shape/shape.h"

namespace vitrine {

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
