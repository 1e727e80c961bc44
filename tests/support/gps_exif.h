// EXIF blocks with a GPS directory, for photos of known places.
#pragma once

#include <cmath>
#include <optional>
#include <utility>

#include "tests/support/tiny_photos.h"

namespace vitrine::test {

inline std::string rationals(const std::vector<std::pair<unsigned, unsigned>>& values, bool big_endian = false) {
  Fields out(big_endian);
  for (const auto& [numerator, denominator] : values) out.u32(numerator), out.u32(denominator);
  return out.bytes;
}

// Degrees, minutes and seconds to a ten-millionth of a second, which is 3 micrometres of latitude.
inline std::string angle_rationals(double degrees, bool big_endian = false) {
  constexpr unsigned kParts = 10'000'000;
  const double all = std::abs(degrees), minutes = (all - std::floor(all)) * 60;
  return rationals({{static_cast<unsigned>(all), 1},
                    {static_cast<unsigned>(minutes), 1},
                    {static_cast<unsigned>(std::lround((minutes - std::floor(minutes)) * 60 * kParts)), kParts}},
                   big_endian);
}

// Latitude, longitude and, where known, altitude in millimetres.
inline std::vector<Tag> place_tags(double latitude, double longitude, std::optional<double> altitude, bool big_endian = false) {
  std::vector<Tag> tags{{0x0001, 'a', 0, 1, latitude < 0 ? "S" : "N"},
                        {0x0002, 'R', 0, 1, angle_rationals(latitude, big_endian)},
                        {0x0003, 'a', 0, 1, longitude < 0 ? "W" : "E"},
                        {0x0004, 'R', 0, 1, angle_rationals(longitude, big_endian)}};
  if (altitude) {
    tags.push_back({0x0005, 'b', *altitude < 0 ? 1u : 0u});
    tags.push_back({0x0006, 'r', static_cast<unsigned>(std::lround(1000 * std::abs(*altitude))), 1000});
  }
  return tags;
}

// "Exif\0\0" + TIFF structure with IFD0 and the GPS directory.
inline std::string exif_with_gps(const std::vector<Tag>& gps, bool big_endian = false) {
  std::vector<Tag> ifd0{{0x010f, 'a', 0, 1, "Maker"}, {0x8825, 'l', 0}};
  const unsigned gps_at = 8 + static_cast<unsigned>(directory(ifd0, 8, big_endian).size());
  ifd0.back().a = gps_at;
  Fields header(big_endian);
  header.raw(big_endian ? "MM" : "II");
  header.u16(42);
  header.u32(8);
  return std::string("Exif\0\0", 6) + header.bytes + directory(ifd0, 8, big_endian) + directory(gps, gps_at, big_endian);
}

}  // namespace vitrine::test
