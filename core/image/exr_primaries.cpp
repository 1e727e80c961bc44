#include "core/image/exr_primaries.h"

#include <bit>

#include "core/image/segments.h"

namespace vitrine {

ExrPrimaries exr_primaries(std::string_view bytes) {
  ExrPrimaries out;
  const std::string_view raw = exr_attribute(bytes, "chromaticities", "chromaticities");
  if (raw.size() != 32) return out;
  double v[8];
  for (size_t i = 0; i < 8; ++i) v[i] = std::bit_cast<float>(static_cast<uint32_t>(number_at(raw, 4 * i, 4, false)));
  const Chromaticities c{v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7]};
  if (ColorProfilePtr profile = primaries_profile("linear " + primaries_name(c), c)) {
    out.profile = std::move(profile);
    out.stated = true;
  } else {
    out.problem = "its chromaticities are impossible";
  }
  return out;
}

}  // namespace vitrine
