#include "core/scene/image/repair.h"

#include <cmath>

#include <fmt/format.h>

namespace vitrine {

namespace {
constexpr float kBrightest = 65504.0f;  // half-float maximum, used by the EXR files we write
}

RepairedValues repair_values(ImageF& image, float darkest) {
  RepairedValues r;
  for (float& v : image.data()) {
    if (v >= darkest && v <= kBrightest) continue;
    if (std::isnan(v) || v == -INFINITY)
      ++r.not_numbers, v = 0;
    else if (v > kBrightest)
      ++r.too_bright, v = kBrightest;
    else
      ++r.negative, v = darkest;
  }
  return r;
}

RepairedValues& RepairedValues::operator+=(const RepairedValues& o) {
  not_numbers += o.not_numbers;
  too_bright += o.too_bright;
  negative += o.negative;
  return *this;
}

std::string RepairedValues::text() const {
  std::string out;
  const auto add = [&](size_t n, std::string_view which, std::string_view now) {
    if (n > 0) out += fmt::format("{}{}{} {} to {}", out.empty() ? "" : ", ", n, out.empty() ? " values" : "", which, now);
  };
  add(not_numbers, "that are not numbers were set", "0");
  add(too_bright, out.empty() ? "above 65504 (or infinite) were set" : "above 65504 (or infinite)", "65504");
  add(negative, out.empty() ? "below 0 were set" : "below 0", "0");
  return out;
}

}  // namespace vitrine
