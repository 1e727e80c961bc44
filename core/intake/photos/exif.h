// EXIF metadata of a photo, read with libexif: orientation, focal length, exposure, camera, time, place.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace vitrine {

// Place of the camera by its receiver (EXIF 2.3, GPS directory).
struct GpsPosition {
  double latitude = 0, longitude = 0;   // degrees, north and east positive
  std::optional<double> altitude = {};  // metres above sea level
  std::string datum = {};               // GPSMapDatum where it differs from WGS84 by more than a metre, else empty
  std::optional<double> error_m = {};   // horizontal error as stated: GPSHPositioningError, else from GPSDOP
  bool operator==(const GpsPosition&) const = default;
};

struct Exif {
  int orientation = 1;               // 1..8
  std::optional<double> focal_35mm;  // FocalLengthIn35mmFilm
  std::optional<double> focal_mm;
  std::optional<double> pixels_per_mm;  // FocalPlaneXResolution in its unit
  double digital_zoom = 1;              // DigitalZoomRatio, at least 1
  double pixel_x = 0, pixel_y = 0;      // size of the photo when EXIF was written, 0 = missing
  std::optional<double> exposure_s, f_number, iso;
  std::string camera, time;
  bool flash = false;              // Flash, bit 0: the camera's flash fired
  int color_space = -1;            // ColorSpace: 1 = sRGB, 2 = Adobe RGB, 65535 = uncalibrated; -1 = missing
  std::string interoperability;    // InteroperabilityIndex: "R98", "R03" (Adobe RGB), or empty
  std::optional<GpsPosition> gps;  // nullopt: missing, out of range, or zero in both angles
};

// `block`: from exif_block. Damaged blocks return the readable fields, an empty one the defaults.
Exif parse_exif(std::string_view block);

struct Focal {
  double px;           // at the requested size
  std::string source;  // the EXIF fields used
};
// Focal length in pixels of a photo of width x height. The 35 mm equivalent compares diagonals (CIPA DCG-001):
// f = f35 hypot(w, h) / 43.27 mm. Otherwise f = focal_mm * pixels_per_mm. Both are at the size stored in EXIF, then scaled to
// this one; a crop that keeps one side at full length is detected. nullopt when unknown or implausible.
std::optional<Focal> focal_of(const Exif& exif, int width, int height);

// FocalLength in millimetres times digital zoom: comparable between photos of one camera. nullopt: neither is written.
std::optional<double> zoom_of(const Exif& exif);

// EV at ISO 100: log2(N^2 / t) - log2(S / 100). A difference of 1 EV is a factor of 2 in scene radiance per pixel value.
std::optional<double> exposure_ev(const Exif& exif);

}  // namespace vitrine
