// The kinds of shapes, one row each: what files and tests need of them, beside the members that shape.h asks for. A new kind is
// an alternative of Shape and a row; tests/core/scene/shape tries every row.
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
  // Its numbers; what `mesh` returns, if it is not nullptr, is kept in a file of its own.
  nlohmann::ordered_json (*write)(const Shape&);
  const TriMesh* (*mesh)(const Shape&);
  // nullopt, or nlohmann's exceptions, if the numbers are no such shape.
  std::optional<Shape> (*read)(const nlohmann::json&, TriMesh mesh);
  Shape (*sample)(Rng&);  // about one unit large, near the origin
  double precision;       // of its hits
  double gradient_error;  // of hit_vjp, relative: what it leaves out
};

std::span<const ShapeKind> shape_kinds();  // [Shape::index()]
inline const ShapeKind& kind_of(const Shape& shape) { return shape_kinds()[shape.index()]; }
const ShapeKind* find_shape_kind(std::string_view name);

}  // namespace vitrine
