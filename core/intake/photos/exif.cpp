#include "core/intake/photos/exif.h"

#include <array>
#include <cctype>
#include <cmath>
#include <memory>

#include <libexif/exif-data.h>

namespace vitrine {

namespace {

using ExifPtr = std::unique_ptr<ExifData, decltype(&exif_data_unref)>;

const ExifEntry* entry_of(ExifData* data, ExifIfd ifd, ExifTag tag) {
  ExifEntry* e = exif_content_get_entry(data->ifd[ifd], tag);
  return e && e->data && e->components > 0 ? e : nullptr;
}

// The first value of a numeric entry; nullopt unless finite and positive, as all requested fields must be.
std::optional<double> positive(ExifData* data, ExifIfd ifd, ExifTag tag) {
  const ExifEntry* e = entry_of(data, ifd, tag);
  if (!e || e->size < exif_format_get_size(e->format)) return std::nullopt;
  const ExifByteOrder order = exif_data_get_byte_order(data);
  double v = 0;
  switch (e->format) {
    case EXIF_FORMAT_SHORT:
      v = exif_get_short(e->data, order);
      break;
    case EXIF_FORMAT_LONG:
      v = exif_get_long(e->data, order);
      break;
    case EXIF_FORMAT_RATIONAL: {
      const ExifRational r = exif_get_rational(e->data, order);
      v = r.denominator ? double(r.numerator) / r.denominator : 0;
      break;
    }
    default:
      return std::nullopt;
  }
  return v > 0 ? std::optional(v) : std::nullopt;
}

// Printable ASCII without padding.
std::string text(ExifData* data, ExifIfd ifd, ExifTag tag) {
  const ExifEntry* e = entry_of(data, ifd, tag);
  if (!e || e->format != EXIF_FORMAT_ASCII) return "";
  std::string s;
  for (unsigned i = 0; i < e->size && e->data[i] != 0; ++i)
    s += e->data[i] >= 0x20 && e->data[i] < 0x7f ? static_cast<char>(e->data[i]) : '?';
  const size_t first = s.find_first_not_of(' '), last = s.find_last_not_of(' ');
  return first == std::string::npos ? "" : s.substr(first, last - first + 1);
}

std::string camera_name(const std::string& maker, const std::string& model) {
  if (maker.empty() || model.starts_with(maker)) return model;
  return model.empty() ? maker : maker + " " + model;
}

std::optional<double> millimetres_per_unit(double unit) {  // FocalPlaneResolutionUnit
  switch (static_cast<int>(unit)) {
    case 2:
      return 25.4;
    case 3:
      return 10.0;
    case 4:
      return 1.0;
    case 5:
      return 0.001;
    default:
      return std::nullopt;
  }
}

// 65535 in the old field of 16 bits means "more than this": the value is in the fields of EXIF 2.3, if anywhere.
std::optional<double> sensitivity(ExifData* data) {
  constexpr double kMoreThan = 65535;
  for (const ExifTag tag : {EXIF_TAG_ISO_SPEED_RATINGS, EXIF_TAG_RECOMMENDED_EXPOSURE_INDEX, EXIF_TAG_STANDARD_OUTPUT_SENSITIVITY,
                            EXIF_TAG_ISO_SPEED})
    if (const auto iso = positive(data, EXIF_IFD_EXIF, tag); iso && *iso != kMoreThan) return iso;
  return std::nullopt;
}

// Degrees, minutes and seconds as rationals (EXIF 2.3, GPSLatitude). A part of 0/0 after the first counts as zero.
std::optional<double> angle_deg(ExifData* data, ExifTag tag, double limit) {
  const ExifEntry* e = entry_of(data, EXIF_IFD_GPS, tag);
  if (!e || e->format != EXIF_FORMAT_RATIONAL || e->components > 3) return std::nullopt;
  const unsigned step = exif_format_get_size(EXIF_FORMAT_RATIONAL);
  if (e->size < step * e->components) return std::nullopt;
  const ExifByteOrder order = exif_data_get_byte_order(data);
  constexpr std::array<double, 3> kParts{1, 60, 3600};
  double sum = 0;
  for (unsigned i = 0; i < e->components; ++i) {
    const ExifRational r = exif_get_rational(e->data + step * i, order);
    if (r.denominator == 0 && (i == 0 || r.numerator != 0)) return std::nullopt;
    const double part = r.denominator != 0 ? double(r.numerator) / r.denominator : 0;
    if (i > 0 && part > 60) return std::nullopt;  // 60 itself is 59.99 rounded
    sum += part / kParts[i];
  }
  return sum <= limit ? std::optional(sum) : std::nullopt;
}

// GPSAltitudeRef: 1 and 3 are below zero. An altitude of exactly zero is what receivers write that do not know it.
std::optional<double> altitude_m(ExifData* data) {
  constexpr double kHighest = 20000, kLowest = 12000;
  const auto above = positive(data, EXIF_IFD_GPS, ExifTag(EXIF_TAG_GPS_ALTITUDE));
  if (!above) return std::nullopt;
  const ExifEntry* e = entry_of(data, EXIF_IFD_GPS, ExifTag(EXIF_TAG_GPS_ALTITUDE_REF));
  const bool below = e && e->format == EXIF_FORMAT_BYTE && (e->data[0] & 1) != 0;
  if (*above > (below ? kLowest : kHighest)) return std::nullopt;
  return below ? -*above : *above;
}

// Horizontal error in metres. A dilution of precision multiplies the error of one range, a few metres on receivers of one
// frequency (GPS SPS Performance Standard, 2020).
std::optional<double> stated_error_m(ExifData* data) {
  constexpr double kRangeError_m = 2.5;
  if (const auto error = positive(data, EXIF_IFD_GPS, ExifTag(EXIF_TAG_GPS_H_POSITIONING_ERROR))) return error;
  const auto dilution = positive(data, EXIF_IFD_GPS, ExifTag(EXIF_TAG_GPS_DOP));
  return dilution ? std::optional(kRangeError_m * *dilution) : std::nullopt;
}

// Datums within a metre of WGS84 give an empty name.
std::string other_datum(const std::string& written) {
  std::string letters;
  for (const char c : written)
    if (std::isalnum(static_cast<unsigned char>(c))) letters += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const char* same : {"WGS84", "WGS1984", "JGD2000", "JGD2011", "ETRS89", "NAD83", "GDA94", "GDA2020", "ITRF"})
    if (letters.starts_with(same)) return "";
  return letters.empty() ? "" : written;
}

std::optional<GpsPosition> gps_position(ExifData* data) {
  const auto latitude = angle_deg(data, ExifTag(EXIF_TAG_GPS_LATITUDE), 90);
  const auto longitude = angle_deg(data, ExifTag(EXIF_TAG_GPS_LONGITUDE), 180);
  if (!latitude || !longitude || (*latitude == 0 && *longitude == 0)) return std::nullopt;
  const std::string ns = text(data, EXIF_IFD_GPS, ExifTag(EXIF_TAG_GPS_LATITUDE_REF));
  const std::string ew = text(data, EXIF_IFD_GPS, ExifTag(EXIF_TAG_GPS_LONGITUDE_REF));
  if ((ns != "N" && ns != "S") || (ew != "E" && ew != "W")) return std::nullopt;
  return GpsPosition{.latitude = ns == "S" ? -*latitude : *latitude,
                     .longitude = ew == "W" ? -*longitude : *longitude,
                     .altitude = altitude_m(data),
                     .datum = other_datum(text(data, EXIF_IFD_GPS, ExifTag(EXIF_TAG_GPS_MAP_DATUM))),
                     .error_m = stated_error_m(data)};
}

}  // namespace

Exif parse_exif(std::string_view block) {
  Exif exif;
  if (block.empty()) return exif;
  const ExifPtr data(exif_data_new(), &exif_data_unref);
  if (!data) return exif;
  // Keep the values as stored; "fixing" would rewrite formats and drop entries.
  exif_data_unset_option(data.get(), EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
  exif_data_load_data(data.get(), reinterpret_cast<const unsigned char*>(block.data()), static_cast<unsigned>(block.size()));
  ExifData* d = data.get();
  const double orientation = positive(d, EXIF_IFD_0, EXIF_TAG_ORIENTATION).value_or(1);
  if (orientation <= 8) exif.orientation = static_cast<int>(orientation);
  exif.focal_35mm = positive(d, EXIF_IFD_EXIF, EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM);
  exif.focal_mm = positive(d, EXIF_IFD_EXIF, EXIF_TAG_FOCAL_LENGTH);
  exif.digital_zoom = std::max(positive(d, EXIF_IFD_EXIF, EXIF_TAG_DIGITAL_ZOOM_RATIO).value_or(1), 1.0);
  const auto resolution = positive(d, EXIF_IFD_EXIF, EXIF_TAG_FOCAL_PLANE_X_RESOLUTION);
  const auto unit_mm = millimetres_per_unit(positive(d, EXIF_IFD_EXIF, EXIF_TAG_FOCAL_PLANE_RESOLUTION_UNIT).value_or(2));
  if (resolution && unit_mm) exif.pixels_per_mm = *resolution / *unit_mm;
  exif.pixel_x = positive(d, EXIF_IFD_EXIF, EXIF_TAG_PIXEL_X_DIMENSION).value_or(0);
  exif.pixel_y = positive(d, EXIF_IFD_EXIF, EXIF_TAG_PIXEL_Y_DIMENSION).value_or(0);
  exif.exposure_s = positive(d, EXIF_IFD_EXIF, EXIF_TAG_EXPOSURE_TIME);
  exif.f_number = positive(d, EXIF_IFD_EXIF, EXIF_TAG_FNUMBER);
  exif.iso = sensitivity(d);
  exif.flash = (static_cast<int>(positive(d, EXIF_IFD_EXIF, EXIF_TAG_FLASH).value_or(0)) & 1) != 0;
  exif.camera = camera_name(text(d, EXIF_IFD_0, EXIF_TAG_MAKE), text(d, EXIF_IFD_0, EXIF_TAG_MODEL));
  exif.time = text(d, EXIF_IFD_EXIF, EXIF_TAG_DATE_TIME_ORIGINAL);
  if (exif.time.empty()) exif.time = text(d, EXIF_IFD_0, EXIF_TAG_DATE_TIME);
  if (const auto space = positive(d, EXIF_IFD_EXIF, EXIF_TAG_COLOR_SPACE)) exif.color_space = static_cast<int>(*space);
  exif.interoperability = text(d, EXIF_IFD_INTEROPERABILITY, EXIF_TAG_INTEROPERABILITY_INDEX);
  exif.gps = gps_position(d);
  return exif;
}

std::optional<Focal> focal_of(const Exif& exif, int width, int height) {
  const double longest = std::max(width, height), shortest = std::min(width, height);
  // Size of the camera's original picture, before cropping or resizing. For a crop that keeps one side at full length, the other
  // side shrinks more.
  const bool size_written = exif.pixel_x > 0 && exif.pixel_y > 0;
  const double camera_longest = size_written ? std::max(exif.pixel_x, exif.pixel_y) : longest;
  const double camera_shortest = size_written ? std::min(exif.pixel_x, exif.pixel_y) : shortest;
  const double scale = std::max(longest / camera_longest, shortest / camera_shortest);
  // From a fisheye of 10 mm to a telescope: values outside this range are invalid.
  const auto plausible = [&](double px) { return px > 0.25 * longest && px < 40 * longest; };
  if (exif.focal_35mm) {
    constexpr double kFilmDiagonalMm = 43.2666153;  // 36 mm x 24 mm
    const double px = *exif.focal_35mm * std::hypot(camera_longest, camera_shortest) / kFilmDiagonalMm * scale;
    if (plausible(px)) return Focal{px, "exif FocalLengthIn35mmFilm"};
  }
  if (exif.focal_mm && exif.pixels_per_mm) {
    // Sensor sizes range from a phone's front camera to a large-format back; invalid fields fall outside.
    const double sensor_mm = camera_longest / *exif.pixels_per_mm;
    const double px = *exif.focal_mm * *exif.pixels_per_mm * scale;
    if (sensor_mm > 2 && sensor_mm < 130 && plausible(px)) return Focal{px, "exif FocalLength and FocalPlaneXResolution"};
  }
  return std::nullopt;
}

std::optional<double> zoom_of(const Exif& exif) {
  if (!exif.focal_mm && exif.digital_zoom == 1) return std::nullopt;
  return exif.focal_mm.value_or(1) * exif.digital_zoom;
}

std::optional<double> exposure_ev(const Exif& exif) {
  if (!exif.exposure_s || !exif.f_number || !exif.iso) return std::nullopt;
  return std::log2(*exif.f_number * *exif.f_number / *exif.exposure_s) - std::log2(*exif.iso / 100);
}

}  // namespace vitrine
