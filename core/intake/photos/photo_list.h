// Reads and writes ingest/photos.json: the photos of a capture after ingest, sorted by name.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/intake/photos/exif.h"

namespace vitrine {

// A view cut from a panorama: all views of one panorama have one centre and known rotations.
struct PhotoRig {
  std::string panorama;  // source of the panorama
  Quatd rotation;        // view_from_panorama, unit
  bool operator==(const PhotoRig&) const = default;
};

struct Photo {
  // Unique path of the photo in all later stages, "left/IMG_0001.JPG": the user's path, except that .exr becomes .png and a
  // second photo of the same stem gets its extension appended to the stem (a.jpg, a.png -> a.jpg, a_png.png).
  std::string name;
  std::string stem;                             // name without extension, unique: ingest/linear/<stem>.exr, ingest/ldr/<stem>.png
  std::string source;                           // path below the user's photo folder
  int width = 0, height = 0;                    // upright, as ingested
  int original_width = 0, original_height = 0;  // upright, before the limit on the longest side
  int orientation = 1;                // EXIF 1..8: how the stored pixels were turned to be upright (core/scene/image/resample.h)
  std::optional<double> focal_px;     // at the ingested size
  std::string focal_source;           // "exif FocalLengthIn35mmFilm", "exif FocalLength and FocalPlaneXResolution", or empty
  std::optional<double> exposure_ev;  // log2(N^2 / (t S/100)): the scene luminance this photo was exposed for
  std::string camera;                 // maker and model, or empty
  std::string time;                   // EXIF DateTimeOriginal, "YYYY:MM:DD HH:MM:SS", or empty
  std::string color_profile;          // "sRGB", "Display P3", "linear Rec. 709": colour space of the file
  std::string color_source;           // its source: "icc", "exif ColorSpace", "png cICP", "float linear", "assumed sRGB", ...
  bool flash = false;                 // the camera's flash fired: the light moves with the camera
  bool cut_out = false;               // its file has an alpha channel that varies: the background may be missing
  std::optional<double> zoom;         // FocalLength in millimetres times DigitalZoomRatio: equal for photos with one focal length
  std::optional<GpsPosition> gps;     // place of the camera by EXIF
  std::optional<PhotoRig> rig;        // of a view cut from a panorama; its focal length is exact
  bool operator==(const Photo&) const = default;
};

// `folder` is an ingest artifact. Throws Error{Input} with file and cause.
std::vector<Photo> read_photo_list(const std::filesystem::path& folder);
void write_photo_list(const std::filesystem::path& folder, const std::vector<Photo>& photos);

std::filesystem::path ingested_linear_path(const std::filesystem::path& folder, const Photo& photo);
std::filesystem::path ingested_ldr_path(const std::filesystem::path& folder, const Photo& photo);

}  // namespace vitrine
