// Shape sets in files: a list in a JSON document, and meshes as shape_<entry>.ply beside it.
//   {"kind": "box", "role": "sheet", "tolerance": 0.02, "parent": 3, "clear": [1, 1, ...], ... the kind's numbers (registry.h)}
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/shape/shape_set.h"

namespace vitrine {

nlohmann::ordered_json write_shapes(const ShapeSet& set, const std::filesystem::path& folder);

// Throws std::domain_error with a cause, or nlohmann's exceptions, if the list is no such set; what reading a mesh throws.
ShapeSet read_shapes(const nlohmann::json& json, const std::filesystem::path& folder);

}  // namespace vitrine
