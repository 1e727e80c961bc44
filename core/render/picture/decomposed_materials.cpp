#include "core/render/picture/decomposed_materials.h"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
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
constexpr std::string_view kBehindGlass = "element behind_glass ", kSubsurface = "element subsurface ";
constexpr std::array<const char*, 3> kMeanFreePath{"mean_free_path_r", "mean_free_path_g", "mean_free_path_b"};
constexpr size_t kMaxSurfels = size_t(1) << 31;
using Row = std::array<float, kProperties.size()>;
constexpr std::span<const char* const> kAlbedo = std::span(kProperties).first(3);

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
  const std::vector<Vec3f>& behind = m.albedo_behind_glass;
  if (!behind.empty()) bytes += fmt::format("{}{}{}", kBehindGlass, behind.size(), properties(kAlbedo));
  if (!m.scatter.empty()) bytes += fmt::format("{}{}{}", kSubsurface, m.scatter.size(), properties(kMeanFreePath));
  bytes += kEndOfHeader;
  const size_t start = bytes.size();
  bytes.resize(start + m.size() * sizeof(Row));
  for (size_t i = 0; i < m.size(); ++i) {
    const Row row{m.albedo[i].x, m.albedo[i].y, m.albedo[i].z,        m.roughness[i],   m.f0[i].x,
                  m.f0[i].y,     m.f0[i].z,     m.specular_weight[i], m.transmission[i]};
    std::memcpy(bytes.data() + start + i * sizeof(Row), row.data(), sizeof(Row));
  }
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  for (const std::vector<Vec3f>* more : {&behind, &m.scatter})
    bytes.append(reinterpret_cast<const char*>(more->data()), more->size() * sizeof(Vec3f));
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
  size_t behind = 0, scattering = 0;
  if (text.substr(at).starts_with(kBehindGlass)) {
    at += kBehindGlass.size();
    behind = element(kAlbedo);
  }
  if (text.substr(at).starts_with(kSubsurface)) {
    at += kSubsurface.size();
    scattering = element(kMeanFreePath);
    if (scattering != count) throw fail(fmt::format("{} surfels have a material, {} a mean free path", count, scattering));
  }
  if (!text.substr(at).starts_with(kEndOfHeader)) throw fail("it has other properties than the decompose stage writes");
  const size_t start = at + kEndOfHeader.size(), after = start + count * sizeof(Row);
  const size_t wanted = count * sizeof(Row) + (behind + scattering) * sizeof(Vec3f), present = bytes.size() - start;
  if (present != wanted) throw fail(fmt::format("{} surfels need {} bytes, {} are there", count + behind, wanted, present));
  DecomposedMaterials m;
  m.resize(count);
  m.albedo_behind_glass.resize(behind);
  if (behind > 0) std::memcpy(m.albedo_behind_glass.data(), bytes.data() + after, behind * sizeof(Vec3f));
  m.scatter.resize(scattering);
  if (scattering > 0) std::memcpy(m.scatter.data(), bytes.data() + after + behind * sizeof(Vec3f), scattering * sizeof(Vec3f));
  for (size_t i = 0; i < scattering; ++i)
    for (size_t c = 0; c < 3; ++c)
      if (const float v = m.scatter[i][c]; !(v >= 0.f && std::isfinite(v)))
        throw fail(fmt::format("{} of surfel {} is no length", kMeanFreePath[c], i));
  for (size_t i = 0; i < behind; ++i)
    for (size_t c = 0; c < kAlbedo.size(); ++c)
      if (const float v = m.albedo_behind_glass[i][c]; !(v >= 0.f && v <= 1.f))
        throw fail(fmt::format("{} of surfel {} behind glass is not in [0, 1]", kProperties[c], i));
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
