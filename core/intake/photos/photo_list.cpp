#include "core/intake/photos/photo_list.h"

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
