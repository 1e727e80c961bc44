#include "core/render/picture/decomposed_materials.h"

#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <span>
#include <string>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"

namespace vitrine {

namespace {

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

constexpr std::array<const char*, 9> kProperties{"albedo_r", "albedo_g", "albedo_b",        "roughness",   "f0_r",
                                                 "f0_g",     "f0_b",     "specular_weight", "transmission"};
constexpr std::string_view kBeforeCount =
    "ply\nformat binary_little_endian 1.0\ncomment vitrine_relight_materials 1\ncomment color lin_rec709\nelement vertex ";
constexpr std::array<const char*, 3> kMeanFreePath{"mean_free_path_r", "mean_free_path_g", "mean_free_path_b"},
    kMarks{"marks_x", "marks_y", "marks_z"};
constexpr std::span<const char* const> kAlbedo = std::span(kProperties).first(3);

// Elements that a file may have, in this order.
struct Element {
  std::string_view word;
  std::span<const char* const> names;
  std::vector<Vec3f> DecomposedMaterials::*values;
  float low, high;
  bool of_diffuse;  // one per surfel of the diffuse layer
};
constexpr float kAny = std::numeric_limits<float>::max();
constexpr Element kElements[] = {{"element behind_glass ", kAlbedo, &DecomposedMaterials::albedo_behind_glass, 0, 1, false},
                                 {"element subsurface ", kMeanFreePath, &DecomposedMaterials::scatter, 0, kAny, true},
                                 {"element brushed ", kMarks, &DecomposedMaterials::marks, -1, 1, true}};
constexpr size_t kMaxSurfels = size_t(1) << 31;
using Row = std::array<float, kProperties.size()>;

// The header lines of an element after its count.
std::string properties(std::span<const char* const> names) {
  std::string text = "\n";
  for (const char* name : names) text += fmt::format("property float {}\n", name);
  return text;
}

constexpr std::string_view kEndOfHeader = "end_header\n";

}  // namespace

void DecomposedMaterials::resize(size_t surfels) {
  albedo.resize(surfels);
  roughness.resize(surfels);
  f0.resize(surfels);
  specular_weight.resize(surfels);
  transmission.resize(surfels);
}

void write_decomposed_materials(const fs::path& folder, const DecomposedMaterials& m) {
  std::string bytes = fmt::format("{}{}{}", kBeforeCount, m.size(), properties(kProperties));
  for (const Element& e : kElements)
    if (const auto& values = m.*e.values; !values.empty())
      bytes += fmt::format("{}{}{}", e.word, values.size(), properties(e.names));
  bytes += kEndOfHeader;
  const size_t start = bytes.size();
  bytes.resize(start + m.size() * sizeof(Row));
  for (size_t i = 0; i < m.size(); ++i) {
    const Row row{m.albedo[i].x, m.albedo[i].y, m.albedo[i].z,        m.roughness[i],   m.f0[i].x,
                  m.f0[i].y,     m.f0[i].z,     m.specular_weight[i], m.transmission[i]};
    std::memcpy(bytes.data() + start + i * sizeof(Row), row.data(), sizeof(Row));
  }
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  for (const Element& e : kElements)
    bytes.append(reinterpret_cast<const char*>((m.*e.values).data()), (m.*e.values).size() * sizeof(Vec3f));
  const fs::path path = decomposed_materials_path(folder);
  make_folders(path.parent_path());
  write_file(path, bytes);
}

DecomposedMaterials read_decomposed_materials(const fs::path& folder) {
  const fs::path path = decomposed_materials_path(folder);
  const auto fail = [&](std::string why) {
    return Error(
        ErrorKind::Input, "not a usable file of materials",
        {.where = path.string(), .why = std::move(why), .hint = "run the decompose stage again", .code = "BAD_MATERIALS"});
  };
  const std::string bytes = read_file(path);
  const std::string_view text(bytes);
  if (!text.starts_with(kBeforeCount)) throw fail("its header is not the one that the decompose stage writes");
  size_t at = kBeforeCount.size();
  const auto element = [&](std::span<const char* const> names) {
    size_t count = 0;
    const auto [end, error] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), count);
    if (error != std::errc() || count > kMaxSurfels) throw fail("its header gives no sensible number of surfels");
    at = static_cast<size_t>(end - bytes.data());
    const std::string rest = properties(names);
    if (!text.substr(at).starts_with(rest)) throw fail("it has other properties than the decompose stage writes");
    at += rest.size();
    return count;
  };
  const size_t count = element(kProperties);
  DecomposedMaterials m;
  m.resize(count);
  size_t wanted = count * sizeof(Row), surfels = count;
  for (const Element& e : kElements) {
    if (!text.substr(at).starts_with(e.word)) continue;
    at += e.word.size();
    const size_t values = element(e.names);
    if (e.of_diffuse && values != count) throw fail(fmt::format("{} surfels have materials, {} {}", count, values, e.names[0]));
    wanted += values * sizeof(Vec3f), surfels += e.of_diffuse ? 0 : values;
    if (wanted > bytes.size())
      throw fail(fmt::format("{} surfels need at least {} bytes, {} are there", surfels, wanted, bytes.size()));
    (m.*e.values).resize(values);
  }
  if (!text.substr(at).starts_with(kEndOfHeader)) throw fail("it has other properties than the decompose stage writes");
  const size_t start = at + kEndOfHeader.size(), present = bytes.size() - start;
  if (present != wanted) throw fail(fmt::format("{} surfels need {} bytes, {} are there", surfels, wanted, present));
  size_t from = start + count * sizeof(Row);
  for (const Element& e : kElements) {
    std::vector<Vec3f>& values = m.*e.values;
    if (!values.empty()) std::memcpy(values.data(), bytes.data() + from, values.size() * sizeof(Vec3f));
    from += values.size() * sizeof(Vec3f);
    for (size_t i = 0; i < values.size(); ++i)
      for (size_t c = 0; c < 3; ++c)
        if (const float v = values[i][c]; !(v >= e.low && v <= e.high))
          throw fail(fmt::format("{} of surfel {}{} is not in [{}, {}]", e.names[c], i, e.of_diffuse ? "" : " behind glass",
                                 e.low, e.high));
  }
  for (size_t i = 0; i < count; ++i) {
    Row row;
    std::memcpy(row.data(), bytes.data() + start + i * sizeof(Row), sizeof(Row));
    for (size_t c = 0; c < row.size(); ++c)
      if (!(row[c] >= 0.f && row[c] <= 1.f)) throw fail(fmt::format("{} of surfel {} is not in [0, 1]", kProperties[c], i));
    m.albedo[i] = {row[0], row[1], row[2]};
    m.roughness[i] = row[3];
    m.f0[i] = {row[4], row[5], row[6]};
    m.specular_weight[i] = row[7];
    m.transmission[i] = row[8];
  }
  return m;
}

DecomposedMaterials read_decomposed_materials(const fs::path& folder, const SplatScene& scene) {
  DecomposedMaterials materials = read_decomposed_materials(folder);
  const auto check = [&](size_t found, const SplatLayer& layer, const char* where) {
    if (found != layer.size())
      throw Error(ErrorKind::Input, "the materials belong to another scene",
                  {.where = decomposed_materials_path(folder).string(),
                   .why = fmt::format("{} materials for {} surfels{}", found, layer.size(), where),
                   .hint = "run the decompose stage again",
                   .code = "BAD_MATERIALS"});
  };
  check(materials.size(), scene.diffuse, "");
  if (const size_t behind = materials.albedo_behind_glass.size(); behind > 0) check(behind, scene.transmittance, " behind glass");
  return materials;
}

}  // namespace vitrine
