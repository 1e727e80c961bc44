#include "sample_data/generate/medium.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"

namespace vitrine::generate {

Vec3f Medium::seen(const Vec3f& radiance, float distance) const {
  Vec3f out;
  for (size_t c = 0; c < 3; ++c)
    out[c] = std::exp(-direct[c] * distance) * radiance[c] + veil[c] * (1 - std::exp(-backscatter[c] * distance));
  return out;
}

std::span<const Medium> medium_list() {
  static const std::array<Medium, 4> kMedia{{
      {"coastal", {0.75f, 0.35f, 0.40f}, {0.60f, 0.36f, 0.42f}, {0.06f, 0.22f, 0.24f}},
      {"deep", {0.60f, 0.12f, 0.08f}, {0.50f, 0.14f, 0.12f}, {0.02f, 0.12f, 0.26f}},
      {"green", {0.85f, 0.40f, 0.75f}, {0.70f, 0.42f, 0.70f}, {0.08f, 0.28f, 0.12f}},
      {"haze", {0.45f, 0.45f, 0.45f}, {0.45f, 0.45f, 0.45f}, {0.52f, 0.56f, 0.61f}},
  }};
  return kMedia;
}

Medium medium_named(const std::string& name) {
  const auto found = std::ranges::find(medium_list(), name, &Medium::name);
  if (found != medium_list().end()) return *found;
  std::string names;
  for (const Medium& medium : medium_list()) names += (names.empty() ? "" : ", ") + medium.name;
  throw Error(ErrorKind::Usage, "there is no such medium", {.where = name, .hint = "--medium takes " + names, .code = "USAGE"});
}

void write_medium(const std::filesystem::path& path, const Medium& medium) {
  const auto row = [](const Vec3f& v) { return fmt::format("[{}, {}, {}]", v.x, v.y, v.z); };
  write_file(path,
             fmt::format("{{\n  \"medium\": \"{}\",\n  \"direct_per_m\": {},\n  \"backscatter_per_m\": {},\n  \"veil\": {}\n}}\n",
                         medium.name, row(medium.direct), row(medium.backscatter), row(medium.veil)));
}

}  // namespace vitrine::generate
