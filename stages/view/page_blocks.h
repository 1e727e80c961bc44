// Numeric data of a scene for its page: named arrays in one buffer, with a directory in JSON. Numbers are little-endian and
// stored byte plane by byte plane (the first bytes of all items, then the second ones), which compresses better.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/json.h"
#include "core/scene/shape/shape_set.h"

namespace vitrine {

// Nearest half float (IEEE 754 binary16), clamped to its range.
uint16_t half_bits(float value);
// Rounds to a half float with `mantissa_bits` of the ten mantissa bits, which compresses better.
float rounded_half(float value, int mantissa_bits);

class PageBlocks {
 public:
  // `width`: numbers per item.
  void floats(std::string_view name, std::span<const float> values, int width);
  void halves(std::string_view name, std::span<const float> values, int width, int mantissa_bits = 10);
  void bytes(std::string_view name, std::span<const uint8_t> values, int width);
  void words(std::string_view name, std::span<const uint16_t> values, int width);
  void indices(std::string_view name, std::span<const uint32_t> values, int width);

  // [{"name", "type": f32 f16 u8 u16 u32, "width", "offset", "count"}], count in numbers.
  const nlohmann::ordered_json& directory() const { return directory_; }
  const std::string& buffer() const { return buffer_; }

 private:
  void add(std::string_view name, std::string_view type, const void* data, size_t count, size_t size, int width);

  nlohmann::ordered_json directory_ = nlohmann::ordered_json::array();
  std::string buffer_;
};

// Known shapes for the page: triangles, which are more accurate than surfels for sheets of glass and for mirrors, and
// mirror planes.

// Writes blocks shape_place, shape_normal, shape_part (facet, entry; facet 65535: curved) of vertices, shape_corner of triangles.
// Returns
//   {"entries": [{"role", "tolerance", "closed", "exact", "parent", "object"}], "facets": [{"entry", "normal", "offset",
//   "clear", "at_pane"}]}
// An empty set gives empty lists.
nlohmann::ordered_json add_shapes(const ShapeSet* set, PageBlocks& blocks);

}  // namespace vitrine
