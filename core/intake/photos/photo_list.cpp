#include "core/intake/photos/photo_list.h"

#include <array>
#include <cmath>
#include <stdexcept>

#include "core/foundation/base/file.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/config/json_file.h"

namespace vitrine {

namespace {

constexpr const char* kPhotoListFormat = "photo list";

template <class T>
nlohmann::json json_of(const std::optional<T>& v) {
  return v ? nlohmann::json(*v) : nlohmann::json();
}

std::optional<double> optional_number(const nlohmann::json& j) {
  return j.is_null() ? std::nullopt : std::optional<double>(j.get<double>());
}

nlohmann::json gps_json(const GpsPosition& p) {
  nlohmann::json j{{"latitude", p.latitude}, {"longitude", p.longitude}};
  if (p.altitude) j["altitude"] = *p.altitude;
  if (!p.datum.empty()) j["datum"] = p.datum;
  if (p.error_m) j["error_m"] = *p.error_m;
  return j;
}

GpsPosition gps_of(const nlohmann::json& j) {
  GpsPosition p{.latitude = j.at("latitude").get<double>(), .longitude = j.at("longitude").get<double>()};
  if (!(std::abs(p.latitude) <= 90) || !(std::abs(p.longitude) <= 180))
    throw std::invalid_argument("a latitude or longitude is out of range");
  if (j.contains("altitude")) p.altitude = j.at("altitude").get<double>();
  p.datum = j.value("datum", "");
  if (j.contains("error_m")) p.error_m = j.at("error_m").get<double>();
  if ((p.altitude && !std::isfinite(*p.altitude)) || (p.error_m && !(*p.error_m > 0)))
    throw std::invalid_argument("an altitude is not finite, or an error is not positive");
  return p;
}

std::optional<PhotoRig> rig_of(const nlohmann::json& j, const fs::path& path, const std::string& photo) {
  if (!j.contains("rig")) return std::nullopt;
  const auto q = j.at("rig").at("rotation").get<std::array<double, 4>>();
  const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (!(std::abs(norm - 1) < 1e-6))
    throw_bad_json(path, kPhotoListFormat, "the rotation of '" + photo + "' in its rig is no unit quaternion");
  return PhotoRig{j.at("rig").at("panorama").get<std::string>(), {q[0], q[1], q[2], q[3]}};
}

fs::path with_suffix(const fs::path& folder, const std::string& stem, const char* extension) {
  return folder / (stem + extension);
}

}  // namespace

std::vector<Photo> read_photo_list(const fs::path& folder) {
  const fs::path path = folder / "ingest" / "photos.json";
  std::vector<Photo> photos;
  read_json_file(path, kPhotoListFormat, [&](const nlohmann::json& document) {
    for (const nlohmann::json& j : document.at("photos")) {
      Photo p;
      p.name = j.at("name").get<std::string>();
      p.stem = j.at("stem").get<std::string>();
      p.source = j.at("source").get<std::string>();
      p.width = j.at("width").get<int>();
      p.height = j.at("height").get<int>();
      p.original_width = j.at("original_width").get<int>();
      p.original_height = j.at("original_height").get<int>();
      p.orientation = j.at("orientation").get<int>();
      if (p.orientation < 1 || p.orientation > 8)
        throw_bad_json(path, kPhotoListFormat, "photo '" + p.name + "' has no EXIF orientation of 1 to 8");
      p.focal_px = optional_number(j.at("focal_px"));
      p.focal_source = j.at("focal_source").get<std::string>();
      p.exposure_ev = optional_number(j.at("exposure_ev"));
      p.flash = j.value("flash", false);
      p.cut_out = j.value("cut_out", false);
      if (j.contains("zoom")) p.zoom = optional_number(j.at("zoom"));
      if (j.contains("gps")) p.gps = gps_of(j.at("gps"));
      p.rig = rig_of(j, path, p.name);
      p.camera = j.at("camera").get<std::string>();
      p.time = j.at("time").get<std::string>();
      p.color_profile = j.at("color_profile").get<std::string>();
      p.color_source = j.at("color_source").get<std::string>();
      constexpr int kMaxSide = 1 << 20;
      for (int side : {p.width, p.height, p.original_width, p.original_height})
        if (side <= 0 || side > kMaxSide) throw_bad_json(path, kPhotoListFormat, "photo '" + p.name + "' has no size");
      // Names of files of later stages.
      if (!stays_below(p.name) || !stays_below(p.stem))
        throw_bad_json(path, kPhotoListFormat, "the name '" + p.name + "' is not a path inside a folder");
      photos.push_back(std::move(p));
    }
  });
  return photos;
}

void write_photo_list(const fs::path& folder, const std::vector<Photo>& photos) {
  nlohmann::json list = nlohmann::json::array();
  for (const Photo& p : photos) {
    list.push_back({{"name", p.name},
                    {"stem", p.stem},
                    {"source", p.source},
                    {"width", p.width},
                    {"height", p.height},
                    {"original_width", p.original_width},
                    {"original_height", p.original_height},
                    {"orientation", p.orientation},
                    {"focal_px", json_of(p.focal_px)},
                    {"focal_source", p.focal_source},
                    {"exposure_ev", json_of(p.exposure_ev)},
                    {"camera", p.camera},
                    {"time", p.time},
                    {"color_profile", p.color_profile},
                    {"color_source", p.color_source}});
    if (p.flash) list.back()["flash"] = true;
    if (p.cut_out) list.back()["cut_out"] = true;
    if (p.zoom) list.back()["zoom"] = *p.zoom;
    if (p.gps) list.back()["gps"] = gps_json(*p.gps);
    if (const auto& rig = p.rig)
      list.back()["rig"] = {{"panorama", rig->panorama},
                            {"rotation", {rig->rotation.w, rig->rotation.x, rig->rotation.y, rig->rotation.z}}};
  }
  write_json_file(folder / "ingest" / "photos.json", {{"photos", list}});
}

fs::path ingested_linear_path(const fs::path& folder, const Photo& photo) {
  return with_suffix(folder / "ingest" / "linear", photo.stem, ".exr");
}

fs::path ingested_ldr_path(const fs::path& folder, const Photo& photo) {
  return with_suffix(folder / "ingest" / "ldr", photo.stem, ".png");
}

}  // namespace vitrine
