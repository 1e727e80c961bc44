#include "core/scene/mesh/mesh_io.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/math/color.h"

namespace vitrine {

namespace {

// ---- writing ----------------------------------------------------------------------------------------------------------

uint8_t encoded_byte(float linear) {
  const float s = srgb_from_linear(std::clamp(linear, 0.f, 1.f));
  return static_cast<uint8_t>(std::lround(255.f * std::clamp(s, 0.f, 1.f)));
}

void check_consistent(const TriMesh& mesh) {
  VITRINE_CHECK(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(), "one normal per vertex");
  VITRINE_CHECK(mesh.colors.empty() || mesh.colors.size() == mesh.positions.size(), "one colour per vertex");
  VITRINE_CHECK(mesh.object_ids.empty() || mesh.object_ids.size() == mesh.positions.size(), "one object per vertex");
}

template <class T>
void append_raw(std::string& out, const T& value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}

// ---- reading ----------------------------------------------------------------------------------------------------------

enum class PlyFormat { Ascii, LittleEndian, BigEndian };
enum class Scalar { None, I8, U8, I16, U16, I32, U32, F32, F64 };

size_t size_of(Scalar s) {
  switch (s) {
    case Scalar::None:
      return 0;
    case Scalar::I8:
    case Scalar::U8:
      return 1;
    case Scalar::I16:
    case Scalar::U16:
      return 2;
    case Scalar::I32:
    case Scalar::U32:
    case Scalar::F32:
      return 4;
    case Scalar::F64:
      return 8;
  }
  return 0;
}

Scalar scalar_named(std::string_view word) {
  if (word == "char" || word == "int8") return Scalar::I8;
  if (word == "uchar" || word == "uint8") return Scalar::U8;
  if (word == "short" || word == "int16") return Scalar::I16;
  if (word == "ushort" || word == "uint16") return Scalar::U16;
  if (word == "int" || word == "int32") return Scalar::I32;
  if (word == "uint" || word == "uint32") return Scalar::U32;
  if (word == "float" || word == "float32") return Scalar::F32;
  if (word == "double" || word == "float64") return Scalar::F64;
  return Scalar::None;
}

// Divisor that maps an integer colour to [0, 1].
double full_scale(Scalar s) { return s == Scalar::U8 ? 255.0 : s == Scalar::U16 ? 65535.0 : 1.0; }

struct Property {
  std::string name;
  Scalar type = Scalar::None;
  Scalar list_size = Scalar::None;  // None: a scalar property
};

struct Element {
  std::string name;
  size_t count = 0;
  std::vector<Property> properties;
};

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (size_t i = 0; i < line.size();) {
    if (line[i] == ' ' || line[i] == '\t' || line[i] == '\r') {
      ++i;
      continue;
    }
    size_t j = i;
    while (j < line.size() && line[j] != ' ' && line[j] != '\t' && line[j] != '\r') ++j;
    words.push_back(line.substr(i, j - i));
    i = j;
  }
  return words;
}

class PlyFile {
 public:
  explicit PlyFile(const fs::path& path) : path_(path), bytes_(read_file(path)) { read_header(); }

  TriMesh mesh() {
    TriMesh mesh;
    for (const Element& e : elements_) {
      check_room_for(e);
      if (e.name == "vertex")
        read_vertices(e, mesh);
      else if (e.name == "face")
        read_faces(e, mesh);
      else
        skip(e);
    }
    for (const auto& f : mesh.faces)
      for (uint32_t v : f)
        if (v >= mesh.positions.size()) fail(fmt::format("a face refers to vertex {} of {}", v, mesh.positions.size()));
    return mesh;
  }

 private:
  [[noreturn]] void fail(std::string why) const {
    throw Error(ErrorKind::Input, "cannot read this PLY mesh",
                {.where = path_.string(), .why = std::move(why), .hint = "write the file again", .code = "BAD_PLY"});
  }

  std::string_view header_line() {
    const size_t end = bytes_.find('\n', at_);
    if (end == std::string::npos) fail("the header has no end");
    const std::string_view line = std::string_view(bytes_).substr(at_, end - at_);
    at_ = end + 1;
    return line;
  }

  void read_header() {
    const auto magic = words_of(header_line());
    if (magic.size() != 1 || magic[0] != "ply") fail("it does not begin with `ply`");
    bool has_format = false;
    for (;;) {
      const auto words = words_of(header_line());
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() >= 2) {
        if (words[1] == "ascii")
          format_ = PlyFormat::Ascii;
        else if (words[1] == "binary_little_endian")
          format_ = PlyFormat::LittleEndian;
        else if (words[1] == "binary_big_endian")
          format_ = PlyFormat::BigEndian;
        else
          fail(fmt::format("unknown format `{}`", words[1]));
        has_format = true;
      } else if (words[0] == "element" && words.size() == 3) {
        Element e{std::string(words[1]), 0, {}};
        const auto [end, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), e.count);
        if (error != std::errc() || end != words[2].data() + words[2].size()) fail(fmt::format("bad count `{}`", words[2]));
        elements_.push_back(std::move(e));
      } else if (words[0] == "property" && !elements_.empty()) {
        elements_.back().properties.push_back(property_of(words));
      } else {
        fail(fmt::format("unexpected header line that begins with `{}`", words[0].substr(0, 40)));
      }
    }
    if (!has_format) fail("the header names no format");
  }

  Property property_of(const std::vector<std::string_view>& words) const {
    Property p;
    if (words.size() == 5 && words[1] == "list") {
      p = {std::string(words[4]), scalar_named(words[3]), scalar_named(words[2])};
      if (p.list_size == Scalar::None || p.list_size == Scalar::F32 || p.list_size == Scalar::F64)
        fail(fmt::format("list `{}` has no integer length", p.name));
    } else if (words.size() == 3) {
      p = {std::string(words[2]), scalar_named(words[1]), Scalar::None};
    } else {
      fail("malformed property");
    }
    if (p.type == Scalar::None) fail(fmt::format("property `{}` has an unknown type", p.name));
    return p;
  }

  size_t remaining() const { return bytes_.size() - at_; }

  // Checks before allocation that the file has room for the declared elements.
  void check_room_for(const Element& e) const {
    size_t least = 0;
    for (const Property& p : e.properties) {
      const Scalar first = p.list_size == Scalar::None ? p.type : p.list_size;
      least += format_ == PlyFormat::Ascii ? 2 : size_of(first);  // one digit and a separator
    }
    if (least == 0) return;
    const size_t slack = format_ == PlyFormat::Ascii ? 1 : 0;  // the last separator may be missing
    if (e.count > (remaining() + slack) / least)
      fail(fmt::format("it promises {} of element `{}`, but only {} bytes follow", e.count, e.name, remaining()));
  }

  double next(Scalar type) {
    if (format_ == PlyFormat::Ascii) return next_ascii();
    const size_t size = size_of(type);
    if (remaining() < size) fail("it is truncated");
    const bool swap = (format_ == PlyFormat::BigEndian) == (std::endian::native == std::endian::little);
    unsigned char raw[8] = {};
    for (size_t k = 0; k < size; ++k) raw[k] = static_cast<unsigned char>(bytes_[at_ + (swap ? size - 1 - k : k)]);
    at_ += size;
    switch (type) {
      case Scalar::I8:
        return as<int8_t>(raw);
      case Scalar::U8:
        return as<uint8_t>(raw);
      case Scalar::I16:
        return as<int16_t>(raw);
      case Scalar::U16:
        return as<uint16_t>(raw);
      case Scalar::I32:
        return as<int32_t>(raw);
      case Scalar::U32:
        return as<uint32_t>(raw);
      case Scalar::F32:
        return as<float>(raw);
      case Scalar::F64:
        return as<double>(raw);
      case Scalar::None:
        break;
    }
    return 0;
  }

  template <class T>
  static double as(const unsigned char* raw) {
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return static_cast<double>(value);
  }

  double next_ascii() {
    while (at_ < bytes_.size() && static_cast<unsigned char>(bytes_[at_]) <= ' ') ++at_;
    double value = 0;
    const char* begin = bytes_.data() + at_;
    const auto [end, error] = std::from_chars(begin, bytes_.data() + bytes_.size(), value);
    if (error != std::errc()) fail(at_ >= bytes_.size() ? "it is truncated" : "a value is not a number");
    at_ += static_cast<size_t>(end - begin);
    return value;
  }

  size_t next_list_length(const Property& p) {
    const double n = next(p.list_size);
    const size_t least = format_ == PlyFormat::Ascii ? 2 : size_of(p.type);
    if (!(n >= 0) || n != std::floor(n) || n > static_cast<double>(remaining() / least + 1))
      fail(fmt::format("a list of {} values does not fit", n));
    return static_cast<size_t>(n);
  }

  void skip_property(const Property& p) {
    const size_t n = p.list_size == Scalar::None ? 1 : next_list_length(p);
    for (size_t i = 0; i < n; ++i) next(p.type);
  }

  void skip(const Element& e) {
    if (e.properties.empty()) return;
    for (size_t i = 0; i < e.count; ++i)
      for (const Property& p : e.properties) skip_property(p);
  }

  void read_vertices(const Element& e, TriMesh& mesh) {
    static constexpr std::string_view kNames[10] = {"x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "object_id"};
    std::vector<int> slots;
    bool present[10] = {};
    for (const Property& p : e.properties) {
      const auto found = std::find(std::begin(kNames), std::end(kNames), p.name);
      const bool used = found != std::end(kNames) && p.list_size == Scalar::None;
      slots.push_back(used ? static_cast<int>(found - std::begin(kNames)) : -1);
      if (used) present[slots.back()] = true;
    }
    if (!(present[0] && present[1] && present[2])) fail("the vertices have no x, y, z");
    if (!mesh.positions.empty()) fail("it has two vertex elements");
    const bool normals = present[3] && present[4] && present[5], colors = present[6] && present[7] && present[8];
    const bool objects = present[9];
    mesh.positions.reserve(e.count);
    if (normals) mesh.normals.reserve(e.count);
    if (colors) mesh.colors.reserve(e.count);
    if (objects) mesh.object_ids.reserve(e.count);
    for (size_t i = 0; i < e.count; ++i) {
      float value[10] = {};
      for (size_t k = 0; k < e.properties.size(); ++k) {
        const Property& p = e.properties[k];
        if (slots[k] < 0)
          skip_property(p);
        else
          value[slots[k]] = static_cast<float>(slots[k] >= 6 && slots[k] < 9 ? next(p.type) / full_scale(p.type) : next(p.type));
      }
      for (float v : value)
        if (!std::isfinite(v)) fail(fmt::format("vertex {} is not finite", i));
      mesh.positions.push_back({value[0], value[1], value[2]});
      if (normals) mesh.normals.push_back({value[3], value[4], value[5]});
      if (objects && !(value[9] >= 0 && value[9] <= 65535))
        fail(fmt::format("vertex {} has no id of an object: {}", i, value[9]));
      if (objects) mesh.object_ids.push_back(static_cast<uint16_t>(value[9]));
      if (colors) mesh.colors.push_back({linear_from_srgb(value[6]), linear_from_srgb(value[7]), linear_from_srgb(value[8])});
    }
  }

  void read_faces(const Element& e, TriMesh& mesh) {
    if (e.properties.empty()) fail("the faces have no vertex list");
    std::vector<uint32_t> polygon;
    for (size_t i = 0; i < e.count; ++i) {
      polygon.clear();
      for (const Property& p : e.properties) {
        if (p.list_size == Scalar::None || (p.name != "vertex_indices" && p.name != "vertex_index")) {
          skip_property(p);
          continue;
        }
        for (size_t n = next_list_length(p); n > 0; --n) {
          const double v = next(p.type);
          if (!(v >= 0 && v <= 4294967295.0)) fail(fmt::format("face {} refers to vertex {}", i, v));
          polygon.push_back(static_cast<uint32_t>(v));
        }
      }
      for (size_t k = 2; k < polygon.size(); ++k) mesh.faces.push_back({polygon[0], polygon[k - 1], polygon[k]});
    }
  }

  fs::path path_;
  std::string bytes_;
  size_t at_ = 0;
  PlyFormat format_ = PlyFormat::Ascii;
  std::vector<Element> elements_;
};

}  // namespace

void write_mesh_ply(const fs::path& path, const TriMesh& mesh) {
  check_consistent(mesh);
  std::string out = "ply\nformat binary_little_endian 1.0\ncomment vitrine mesh; colours are sRGB\n";
  out += fmt::format("element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", mesh.positions.size());
  if (!mesh.normals.empty()) out += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.colors.empty()) out += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (!mesh.object_ids.empty()) out += "property ushort object_id\n";
  out += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.faces.size());
  out.reserve(out.size() + mesh.positions.size() * 29 + mesh.faces.size() * 13);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    append_raw(out, mesh.positions[v]);
    if (!mesh.normals.empty()) append_raw(out, mesh.normals[v]);
    if (!mesh.colors.empty())
      for (size_t c = 0; c < 3; ++c) append_raw(out, encoded_byte(mesh.colors[v][c]));
    if (!mesh.object_ids.empty()) append_raw(out, mesh.object_ids[v]);
  }
  for (const auto& f : mesh.faces) {
    append_raw(out, uint8_t{3});
    append_raw(out, f);
  }
  write_file(path, out);
}

TriMesh read_mesh_ply(const fs::path& path) { return PlyFile(path).mesh(); }

}  // namespace vitrine
