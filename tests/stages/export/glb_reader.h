// A parser of GLB files of its own: container, accessors, pictures.
#pragma once

#include <cstring>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/scene/image/ldr.h"

namespace vitrine::test {

inline uint32_t u32_at(const std::string& bytes, size_t at) {
  uint32_t v = 0;
  std::memcpy(&v, bytes.data() + at, 4);
  return v;
}

struct Glb {
  nlohmann::json doc;
  std::string binary;

  explicit Glb(const fs::path& path) {
    const std::string bytes = read_file(path);
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(u32_at(bytes, 4), 2u);
    EXPECT_EQ(u32_at(bytes, 8), bytes.size());
    const uint32_t text = u32_at(bytes, 12);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    EXPECT_EQ(text % 4, 0u);
    doc = nlohmann::json::parse(bytes.substr(20, text));
    EXPECT_EQ(u32_at(bytes, 20 + text), bytes.size() - 28 - text);
    EXPECT_EQ(bytes.substr(24 + text, 3), "BIN");
    binary = bytes.substr(28 + text);
    EXPECT_EQ(doc["buffers"][0]["byteLength"], binary.size());
  }

  std::string view(size_t index) const {
    const nlohmann::json& v = doc["bufferViews"][index];
    EXPECT_LE(size_t(v["byteOffset"]) + size_t(v["byteLength"]), binary.size());
    return binary.substr(v["byteOffset"], v["byteLength"]);
  }
  // All components of an accessor of floats, or of normalised integers.
  std::vector<float> floats(size_t accessor, const std::string& type) const {
    const nlohmann::json& a = doc["accessors"][accessor];
    EXPECT_EQ(a["type"], type);
    const int kind = a["componentType"];
    EXPECT_EQ(a.value("normalized", false), kind != 5126);
    const std::string bytes = view(a["bufferView"]);
    const size_t width = type == "SCALAR" ? 1 : size_t(type[3] - '0'),
                 size = kind == 5126   ? 4
                        : kind == 5120 ? 1
                                       : 2,
                 stride = doc["bufferViews"][size_t(a["bufferView"])].value("byteStride", width * size);
    EXPECT_EQ(bytes.size(), size_t(a["count"]) * stride);
    EXPECT_EQ(stride % 4, 0u);
    std::vector<float> out;
    for (size_t i = 0; i < size_t(a["count"]); ++i)
      for (size_t c = 0; c < width; ++c) out.push_back(number(bytes.data() + i * stride + c * size, kind));
    return out;
  }
  // Of a POSITION, where the node puts them.
  std::vector<float> positions(size_t accessor) const {
    std::vector<float> out = floats(accessor, "VEC3");
    const nlohmann::json& node = doc["nodes"][0];
    for (size_t i = 0; i < out.size(); ++i)
      out[i] = node["translation"][i % 3].get<float>() + node["scale"][i % 3].get<float>() * out[i];
    return out;
  }
  std::vector<uint32_t> indices(size_t accessor) const {
    const nlohmann::json& a = doc["accessors"][accessor];
    const std::string bytes = view(a["bufferView"]);
    const size_t width = a["componentType"] == 5125 ? 4 : 2;
    EXPECT_TRUE(width == 4 || a["componentType"] == 5123);
    std::vector<uint32_t> out(a["count"].get<size_t>(), 0);
    EXPECT_EQ(bytes.size(), width * out.size());
    for (size_t i = 0; i < out.size(); ++i) std::memcpy(&out[i], bytes.data() + width * i, width);
    return out;
  }
  ImageF picture(size_t texture) const {
    const nlohmann::json& image = doc["images"][size_t(doc["textures"][texture]["source"])];
    EXPECT_EQ(image["mimeType"], "image/png");
    const TemporaryFolder folder;
    write_file(folder.path() / "p.png", view(image["bufferView"]));
    return read_unchanged(folder.path() / "p.png");
  }
  // Of the primitive with the material of this name; null when there is none.
  nlohmann::json primitive(const std::string& material) const {
    for (const nlohmann::json& p : doc["meshes"][0]["primitives"])
      if (doc["materials"][size_t(p["material"])]["name"] == material) return p;
    return {};
  }

 private:
  static float number(const char* at, int kind) {
    const auto as = [&](auto value) {
      std::memcpy(&value, at, sizeof value);
      return float(value);
    };
    switch (kind) {
      case 5126:
        return as(0.f);
      case 5123:
        return as(uint16_t(0)) / 65535;
      case 5122:
        return std::max(as(int16_t(0)) / 32767, -1.f);
      case 5120:
        return std::max(as(int8_t(0)) / 127, -1.f);
      default:
        ADD_FAILURE() << "component type " << kind;
        return 0;
    }
  }
};

}  // namespace vitrine::test
