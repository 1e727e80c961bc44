#include "stages/export/formats/glb_file.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"

namespace vitrine {

namespace {

constexpr int kByte = 5120, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963, kNoTarget = 0;

void append_u32(std::string& out, uint32_t v) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(char(v >> shift & 255));
}
void pad(std::string& out, char with) {
  while (out.size() % 4 != 0) out.push_back(with);
}

}  // namespace

GlbFile::GlbFile(std::string_view generator) {
  json["asset"] = {{"version", "2.0"}, {"generator", generator}};
  json["scene"] = 0;
}

void GlbFile::add_place(const GeoOrigin& origin) {
  Json& place = json["asset"]["extras"]["enu_origin"];
  place = {{"latitude", origin.latitude}, {"longitude", origin.longitude}};
  if (origin.altitude) place["altitude"] = *origin.altitude;
  place["axes"] = "x east, y up, z south";
}

int GlbFile::add_view(const void* data, size_t bytes, int target) {
  pad(binary_, 0);
  Json view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes}};
  if (target != kNoTarget) view["target"] = target;
  json["bufferViews"].push_back(std::move(view));
  binary_.append(static_cast<const char*>(data), bytes);
  return int(json["bufferViews"].size()) - 1;
}

int GlbFile::add_accessor(int view, std::string_view type, int component_type, size_t count) {
  json["accessors"].push_back({{"bufferView", view}, {"componentType", component_type}, {"count", count}, {"type", type}});
  return int(json["accessors"].size()) - 1;
}

template <class T>
int GlbFile::add_floats(std::span<const T> values, std::string_view type) {
  return add_accessor(add_view(values.data(), values.size_bytes(), kArrayBuffer), type, kFloat, values.size());
}

int GlbFile::add(std::span<const Vec3f> values, bool bounds) {
  static_assert(sizeof(Vec3f) == 12);
  const int accessor = add_floats(values, "VEC3");
  if (bounds && !values.empty()) {
    Vec3f low = values[0], high = values[0];
    for (const Vec3f& v : values)
      for (size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], v[c]), high[c] = std::max(high[c], v[c]);
    json["accessors"].back()["min"] = {low.x, low.y, low.z};
    json["accessors"].back()["max"] = {high.x, high.y, high.z};
  }
  return accessor;
}
int GlbFile::add(std::span<const std::array<float, 4>> values) { return add_floats(values, "VEC4"); }
int GlbFile::add(std::span<const float> values) { return add_floats(values, "SCALAR"); }

template <class T>
int GlbFile::add_rows(std::span<const T> values, size_t components, int component_type) {
  const size_t row = components * sizeof(T), stride = (row + 3) / 4 * 4, count = values.size() / components;
  std::string bytes(count * stride, '\0');
  for (size_t i = 0; i < count; ++i) std::memcpy(bytes.data() + i * stride, &values[i * components], row);
  const int view = add_view(bytes.data(), bytes.size(), kArrayBuffer);
  json["bufferViews"].back()["byteStride"] = stride;
  const int accessor = add_accessor(view, components == 1 ? "SCALAR" : fmt::format("VEC{}", components), component_type, count);
  json["accessors"].back()["normalized"] = true;
  return accessor;
}

int GlbFile::add_normalized(std::span<const uint16_t> values, size_t components, bool bounds) {
  const int accessor = add_rows(values, components, kUnsignedShort);
  if (bounds && !values.empty()) {
    std::vector<uint16_t> low(values.begin(), values.begin() + long(components)), high = low;
    for (size_t i = 0; i < values.size(); ++i) {
      low[i % components] = std::min(low[i % components], values[i]);
      high[i % components] = std::max(high[i % components], values[i]);
    }
    json["accessors"].back()["min"] = low;
    json["accessors"].back()["max"] = high;
  }
  return accessor;
}
int GlbFile::add_normalized(std::span<const int16_t> values, size_t components) { return add_rows(values, components, kShort); }
int GlbFile::add_normalized(std::span<const int8_t> values, size_t components) { return add_rows(values, components, kByte); }

int GlbFile::add_indices(std::span<const std::array<uint32_t, 3>> faces, size_t vertex_count) {
  if (vertex_count <= 65535) {
    std::vector<uint16_t> narrow;
    for (const auto& f : faces)
      for (uint32_t v : f) narrow.push_back(uint16_t(v));
    return add_accessor(add_view(narrow.data(), narrow.size() * 2, kElementArrayBuffer), "SCALAR", kUnsignedShort, narrow.size());
  }
  return add_accessor(add_view(faces.data(), faces.size_bytes(), kElementArrayBuffer), "SCALAR", kUnsignedInt, 3 * faces.size());
}

int GlbFile::add_texture(std::string_view name, std::string_view png) {
  if (!json.contains("samplers"))
    json["samplers"] = {{{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", 33071}, {"wrapT", 33071}}};  // trilinear, clamped
  json["images"].push_back(
      {{"name", name}, {"mimeType", "image/png"}, {"bufferView", add_view(png.data(), png.size(), kNoTarget)}});
  json["textures"].push_back({{"sampler", 0}, {"source", json["images"].size() - 1}});
  return int(json["textures"].size()) - 1;
}

void GlbFile::use_extension(std::string_view name) {
  Json& used = json["extensionsUsed"];
  if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
}

void GlbFile::require_extension(std::string_view name) {
  use_extension(name);
  Json& required = json["extensionsRequired"];
  if (std::find(required.begin(), required.end(), name) == required.end()) required.push_back(name);
}

void GlbFile::write(const std::filesystem::path& path) {
  pad(binary_, 0);
  json["buffers"] = {{{"byteLength", binary_.size()}}};
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  pad(text, ' ');
  const size_t total = 12 + 8 + text.size() + 8 + binary_.size();
  if (total > 0xffffffffu)
    throw Error(ErrorKind::Resource, "the scene is too large for a GLB file",
                {.where = path.string(),
                 .why = "the format ends at 4 GiB",
                 .hint = "a smaller export.texture_size or mesh.faces",
                 .code = "GLB_TOO_LARGE"});
  std::string bytes = "glTF";
  append_u32(bytes, 2);
  append_u32(bytes, uint32_t(total));
  append_u32(bytes, uint32_t(text.size()));
  bytes += "JSON" + text;
  append_u32(bytes, uint32_t(binary_.size()));
  bytes += std::string("BIN\0", 4) + binary_;
  write_file(path, bytes);
}

}  // namespace vitrine
