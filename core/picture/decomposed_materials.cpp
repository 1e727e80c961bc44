#include "core/picture/decomposed_materials.h"

#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <string>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/file.h"

namespace vitrine {

namespace {

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

constexpr std::array<const char*, 9> kProperties{"albedo_r", "albedo_g", "albedo_b",        "roughness",   "f0_r",
                                                 "f0_g",     "f0_b",     "specular_weight", "transmission"};
constexpr std::string_view kBeforeCount =
    "ply\nformat binary_little_endian 1.0\ncomment vitrine_relight_materials 1\ncomment color lin_rec709\nelement vertex ";
constexpr size_t kMaxSurfels = size_t(1) << 31;
using Row = std::array<float, kProperties.size()>;

std::string after_count() {
  std::string text = "\n";
  for (const char* property : kProperties) text += fmt::format("property float {}\n", property);
  return text + "end_header\n";
}

}  // namespace

void DecomposedMaterials::resize(size_t surfels) {
  albedo.resize(surfels);
  roughness.resize(surfels);
  f0.resize(surfels);
  specular_weight.resize(surfels);
  transmission.resize(surfels);
}

void write_decomposed_materials(const fs::path& folder, const DecomposedMaterials& m) {
  std::string bytes = fmt::format("{}{}{}", kBeforeCount, m.size(), after_count());
  const size_t start = bytes.size();
  bytes.resize(start + m.size() * sizeof(Row));
  for (size_t i = 0; i < m.size(); ++i) {
    const Row row{m.albedo[i].x, m.albedo[i].y, m.albedo[i].z,        m.roughness[i],   m.f0[i].x,
                  m.f0[i].y,     m.f0[i].z,     m.specular_weight[i], m.transmission[i]};
    std::memcpy(bytes.data() + start + i * sizeof(Row), row.data(), sizeof(Row));
  }
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
  size_t count = 0;
  const auto [end, error] = std::from_chars(bytes.data() + kBeforeCount.size(), bytes.data() + bytes.size(), count);
  if (error != std::errc() || count > kMaxSurfels) throw fail("its header gives no sensible number of surfels");
  const size_t header = static_cast<size_t>(end - bytes.data());
  const std::string rest = after_count();
  if (!text.substr(header).starts_with(rest)) throw fail("it has other properties than the decompose stage writes");
  const size_t start = header + rest.size(), wanted = count * sizeof(Row), present = bytes.size() - start;
  if (present != wanted) throw fail(fmt::format("{} surfels need {} bytes, {} are there", count, wanted, present));
  DecomposedMaterials m;
  m.resize(count);
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

}  // namespace vitrine
