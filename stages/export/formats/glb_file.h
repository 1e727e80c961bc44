// A binary glTF 2.0 file being put together: one buffer, JSON in front of it. Knows the container (chunks, alignment, accessors
// with their bounds, images inside the buffer) and nothing about materials.
//   12-byte header "glTF", 2, length | chunk JSON, padded with spaces | chunk BIN, padded with zeros; all little endian
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/foundation/base/json.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

class GlbFile {
 public:
  using Json = nlohmann::ordered_json;
  // Top level of the JSON; asset, buffers, bufferViews, accessors, images are filled in here, the rest by the caller.
  Json json;

  explicit GlbFile(std::string_view generator);

  // Each returns the index of its accessor. `bounds`: write min and max (positions need them).
  int add(std::span<const Vec3f> values, bool bounds = false);
  int add(std::span<const std::array<float, 4>> values);
  int add(std::span<const float> values);
  // [n,components] of [-1, 1] or [0, 1] as normalised integers; rows are padded to four bytes. Needs KHR_mesh_quantization where
  // glTF has floats alone.
  int add_normalized(std::span<const uint16_t> values, size_t components, bool bounds = false);
  int add_normalized(std::span<const int16_t> values, size_t components);
  int add_normalized(std::span<const int8_t> values, size_t components);
  int add_indices(std::span<const std::array<uint32_t, 3>> faces, size_t vertex_count);
  // A texture with a PNG picture inside the buffer; returns the index of the texture.
  int add_texture(std::string_view name, std::string_view png);
  void use_extension(std::string_view name);
  void require_extension(std::string_view name);  // and use it: readers that do not know it must refuse the file

  void write(const std::filesystem::path& path);

 private:
  int add_view(const void* data, size_t bytes, int target);
  int add_accessor(int view, std::string_view type, int component_type, size_t count);
  template <class T>
  int add_floats(std::span<const T> values, std::string_view type);
  template <class T>
  int add_rows(std::span<const T> values, size_t components, int component_type);

  std::string binary_;
};

}  // namespace vitrine
