#include "core/scene/surfels/layers.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/surfels/activation.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

void SplatLayer::fill(float value) {
  constexpr size_t kChunk = 1 << 16;  // floats
  for (auto& array : data_)
    parallel_chunks(array.size(), kChunk,
                    [&](size_t, size_t begin, size_t end) { std::fill(array.data() + begin, array.data() + end, value); });
}

bool is_glass(const SplatLayer& diffuse, size_t i) { return sigmoid(*diffuse.at(Attribute::Transmission, i)) > 0.5f; }

namespace {

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

constexpr std::string_view kMagic = "ply\nformat binary_little_endian 1.0\n";
constexpr int kFormatVersion = 1;
constexpr std::string_view kObjectProperty = "property ushort object_id";
// Far above any scene that fits into memory; larger counts are damaged headers.
constexpr size_t kMaxSurfels = size_t(1) << 31;

// Property names in file order: x y z for the mean (read by every PLY reader), name or name_k for the others.
std::vector<std::string> property_names(const SplatLayer& layer) {
  std::vector<std::string> names;
  for (const AttributeRow& r : kAttributes) {
    const size_t width = layer.width(r.id);
    for (size_t c = 0; c < width; ++c) {
      if (r.id == Attribute::Mean)
        names.emplace_back(1, "xyz"[c]);
      else
        names.push_back(width == 1 ? std::string(r.name) : fmt::format("{}_{}", r.name, c));
    }
  }
  return names;
}

std::string header_of(const SplatLayer& layer) {
  std::string text(kMagic);
  text += fmt::format("comment vitrine_format {}\ncomment vitrine_layer {}\ncomment sh_degree {}\ncomment color lin_rec709\n",
                      kFormatVersion, name(layer.kind()), layer.sh_degree());
  text += fmt::format("element vertex {}\n", layer.size());
  for (const std::string& property : property_names(layer)) text += "property float " + property + "\n";
  if (!layer.object_ids().empty()) text += fmt::format("{}\n", kObjectProperty);
  return text + "end_header\n";
}

class HeaderReader {
 public:
  HeaderReader(const fs::path& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

  [[noreturn]] void fail(std::string why) const {
    throw Error(ErrorKind::Input, "not a usable surfel file",
                {.where = path_.string(),
                 .why = std::move(why),
                 .hint = "run the stage that wrote it again (optimize)",
                 .code = "BAD_LAYER_FILE"});
  }
  std::string_view next_line() {
    const size_t end = bytes_.find('\n', position_);
    if (end == std::string_view::npos || end - position_ > 200) fail("the header is damaged or cut off");
    const std::string_view line = bytes_.substr(position_, end - position_);
    position_ = end + 1;
    return line;
  }
  bool skip_line(std::string_view line) {
    if (!bytes_.substr(position_).starts_with(fmt::format("{}\n", line))) return false;
    position_ += line.size() + 1;
    return true;
  }
  // Remainder of the next line, which must start with `prefix`.
  std::string_view expect(std::string_view prefix) {
    const std::string_view line = next_line();
    if (!line.starts_with(prefix)) fail(fmt::format("expected '{}', found '{}'", prefix, line));
    return line.substr(prefix.size());
  }
  size_t expect_number(std::string_view prefix, size_t highest) {
    const std::string_view text = expect(prefix);
    size_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value > highest)
      fail(fmt::format("'{}{}': a number from 0 to {} belongs there", prefix, text, highest));
    return value;
  }
  size_t position() const { return position_; }

 private:
  const fs::path& path_;
  std::string_view bytes_;
  size_t position_ = 0;
};

}  // namespace

void write_layer(const fs::path& path, const SplatLayer& layer) {
  std::string bytes = header_of(layer);
  size_t floats_per_surfel = 0;
  for (const AttributeRow& r : kAttributes) floats_per_surfel += layer.width(r.id);
  const size_t start = bytes.size();
  const std::span<const uint16_t> ids = layer.object_ids();
  bytes.resize(start + layer.size() * (floats_per_surfel * sizeof(float) + (ids.empty() ? 0 : sizeof(uint16_t))));
  char* out = bytes.data() + start;
  for (size_t i = 0; i < layer.size(); ++i) {
    for (const AttributeRow& r : kAttributes) {
      const size_t size = layer.width(r.id) * sizeof(float);
      if (size > 0) std::memcpy(out, layer.at(r.id, i), size);
      out += size;
    }
    if (ids.empty()) continue;
    std::memcpy(out, &ids[i], sizeof(uint16_t));
    out += sizeof(uint16_t);
  }
  write_file(path, bytes);
}

SplatLayer read_layer(const fs::path& path) {
  const std::string bytes = read_file(path);
  HeaderReader header(path, bytes);
  if (!std::string_view(bytes).starts_with(kMagic)) header.fail("it is not a binary little-endian PLY");
  header.next_line();
  header.next_line();
  const size_t version = header.expect_number("comment vitrine_format ", 1u << 20);
  if (version != kFormatVersion)
    header.fail(fmt::format("format {} is not known here (this program reads {})", version, kFormatVersion));
  const std::string_view layer_name = header.expect("comment vitrine_layer ");
  std::optional<LayerKind> kind;
  for (LayerKind k : kAllLayers)
    if (name(k) == layer_name) kind = k;
  if (!kind) header.fail(fmt::format("unknown layer '{}'", layer_name));
  const int sh_degree = static_cast<int>(header.expect_number("comment sh_degree ", 3));
  header.expect("comment color lin_rec709");
  const size_t count = header.expect_number("element vertex ", kMaxSurfels);

  SplatLayer layer(*kind, sh_degree, 0);
  const std::vector<std::string> names = property_names(layer);
  for (const std::string& property : names)
    if (const std::string_view found = header.expect("property float "); found != property)
      header.fail(fmt::format("property '{}' where '{}' belongs", found, property));
  const bool has_ids = header.skip_line(kObjectProperty);
  header.expect("end_header");

  const size_t wanted = count * (names.size() * sizeof(float) + (has_ids ? sizeof(uint16_t) : 0)),
               present = bytes.size() - header.position();
  if (present != wanted) header.fail(fmt::format("{} surfels need {} bytes, {} are there", count, wanted, present));
  layer.resize(count);
  const char* in = bytes.data() + header.position();
  std::vector<uint16_t> ids(has_ids ? count : 0);
  for (size_t i = 0; i < count; ++i) {
    for (const AttributeRow& r : kAttributes) {
      const size_t width = layer.width(r.id);
      if (width == 0) continue;
      float* values = layer.at(r.id, i);
      std::memcpy(values, in, width * sizeof(float));
      in += width * sizeof(float);
      for (size_t c = 0; c < width; ++c)
        if (!std::isfinite(values[c])) header.fail(fmt::format("{} of surfel {} is not a finite number", r.name, i));
    }
    if (!has_ids) continue;
    std::memcpy(&ids[i], in, sizeof(uint16_t));
    in += sizeof(uint16_t);
  }
  layer.set_object_ids(std::move(ids));
  return layer;
}

}  // namespace vitrine
