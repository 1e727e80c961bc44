// Writer of binary glTF 2.0 files with one buffer. Handles the container (chunks, alignment, accessors with their bounds, images
// inside the buffer), not materials.
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
#include "core/scene/camera/scene_info.h"

namespace vitrine {

class GlbFile {
 public:
  using Json = nlohmann::ordered_json;
  // Top level of the JSON; asset, buffers, bufferViews, accessors and images are filled in here, the rest by the caller.
  Json json;

  explicit GlbFile(std::string_view generator);
  // Place of the origin on the earth, as extras of the asset. The file has +Y up, and +X of the scene is +X.
  void add_place(const GeoOrigin& origin);

  // Each returns its accessor index. `bounds`: write min and max (required for positions).
  int add(std::span<const Vec3f> values, bool bounds = false);
  int add(std::span<const std::array<float, 4>> values);
  int add(std::span<const float> values);
  // [n,components] of [-1, 1] or [0, 1] as normalised integers; rows are padded to four bytes. Requires KHR_mesh_quantization
  // where glTF allows only floats.
  int add_normalized(std::span<const uint16_t> values, size_t components, bool bounds = false);
  int add_normalized(std::span<const int16_t> values, size_t components);
  int add_normalized(std::span<const int8_t> values, size_t components);
  int add_indices(std::span<const std::array<uint32_t, 3>> faces, size_t vertex_count);
  // Adds a texture with a PNG image inside the buffer; returns the texture index.
  int add_texture(std::string_view name, std::string_view png);
  void use_extension(std::string_view name);
  void require_extension(std::string_view name);  // also uses it; readers without it must refuse the file

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
