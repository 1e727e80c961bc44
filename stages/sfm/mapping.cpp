#include "stages/sfm/mapping.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/timer.h"
#include "core/intake/poses/colmap_repair.h"
#include "stages/sfm/features.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

namespace {

// Minimum focal length over longest side: 0.3 is a field of view of 118 degrees. Wrong poses are often compensated by wider
// lenses.
constexpr double kMinFocalRatio = 0.3;
constexpr size_t kMinObservations = 40;  // points of a pose; poses with fewer are removed (twice as many after a retry)

std::vector<ColmapSetting> mapper_settings(const SfmConfig& config, const Rung& rung, bool known_lenses) {
  std::vector<ColmapSetting> s{{"map_threads", "1"},
                               {"map_refine_principal", "0", false},
                               {"map_min_model_size", "3", false},
                               {"map_min_focal_ratio", fmt::format("{}", kMinFocalRatio), false},
                               {"seed", std::to_string(config.seed), false}};
  if (known_lenses) {
    s.push_back({"map_refine_focal", "0"});
    s.push_back({"map_refine_extra", "0"});
  }
  if (rung.relaxed_mapper) {
    s.push_back({"map_init_min_inliers", "50"});
    s.push_back({"map_init_min_angle", "6"});
    s.push_back({"map_pose_min_inliers", "20"});
  }
  return s;
}

// All models below `folder`, best first: most photos, then most points, then the lower number.
std::vector<ColmapModel> models_in(const fs::path& folder) {
  std::vector<std::pair<int, fs::path>> found;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.is_directory() && fs::exists(entry.path() / "images.bin"))
        found.push_back({std::atoi(entry.path().filename().c_str()), entry.path()});
  std::sort(found.begin(), found.end());
  std::vector<ColmapModel> models;
  for (const auto& [number, path] : found) models.push_back(read_colmap_model(path));
  std::stable_sort(models.begin(), models.end(), [](const ColmapModel& a, const ColmapModel& b) {
    return std::pair(a.images.size(), a.points.size()) > std::pair(b.images.size(), b.points.size());
  });
  return models;
}

// Removes photos with a pose from fewer than `least` points until all others have enough; records it in the reports.
void drop_weak_photos(Reconstruction& r, size_t least) {
  while (true) {
    std::set<uint32_t> weak;
    for (const ColmapImage& image : r.model.images) {
      const size_t have = observations_of(image);
      if (have >= least) continue;
      weak.insert(image.id);
      for (PhotoReport& p : r.photos)
        if (p.name == image.name) p.weak_points = have;
    }
    if (weak.empty()) return;
    r.model = without_images(std::move(r.model), weak);
  }
}

}  // namespace

ColmapModel with_photo_names(ColmapModel model, const std::vector<SfmPhoto>& photos) {
  std::map<uint32_t, uint32_t> new_id;
  std::sort(model.images.begin(), model.images.end(), [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  for (size_t i = 0; i < model.images.size(); ++i) {
    const std::optional<size_t> photo = index_of_safe_name(model.images[i].name);
    VITRINE_CHECK(photo && *photo < photos.size(), "model names an image '{}' that we did not give", model.images[i].name);
    new_id[model.images[i].id] = static_cast<uint32_t>(i) + 1;
    model.images[i].id = static_cast<uint32_t>(i) + 1;
    model.images[i].name = photos[*photo].name;
  }
  for (ColmapPoint3D& p : model.points)
    for (ColmapTrackElement& t : p.track) t.image_id = new_id.at(t.image_id);
  check_colmap_model(model, "COLMAP's model");
  return model;
}

std::vector<size_t> run_mapper(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const Rung& rung,
                               const fs::path& models, Reconstruction& now) {
  make_folders(models);
  std::vector<ColmapSetting> settings =
      mapper_settings(config, rung, std::ranges::all_of(desc.photos, [](const SfmPhoto& p) { return p.rig.has_value(); }));
  settings.push_back({"database", now.database.string()});
  settings.push_back({"images", (desc.work_folder / "pictures").string()});
  settings.push_back({"output", models.string()});
  size_t seen = 0;
  Timer timer;
  const ProcessResult result = colmap.run({.command = "mapper",
                                           .settings = settings,
                                           .working_folder = desc.work_folder,
                                           .log = desc.work_folder / "colmap.log",
                                           .on_line = [&](std::string_view line) {
                                             if (line.find("Registering image") == std::string_view::npos) return;
                                             seen = std::min(seen + 1, desc.photos.size());
                                             if (desc.progress)
                                               desc.progress(0.6 + 0.4 * double(seen) / double(desc.photos.size()),
                                                             fmt::format("mapping, photo {}/{}", seen, desc.photos.size()));
                                           }});
  if (desc.timing) desc.timing("map", timer.seconds());
  if (result.signal != 0) log_warning("sfm: COLMAP's mapper was ended by signal {}; what it left is used", result.signal);
  std::vector<ColmapModel> found = models_in(models);
  std::vector<size_t> sizes;
  for (const ColmapModel& m : found) sizes.push_back(m.images.size());
  for (size_t m = 0; m < found.size(); ++m)
    (m == 0 ? now.model : now.smaller_models.emplace_back()) = with_photo_names(std::move(found[m]), desc.photos);
  return sizes;
}

void finish_attempt(Reconstruction& now, Attempt attempt) {
  drop_weak_photos(now, kMinObservations * (now.relaxed ? 2 : 1));
  attempt.registered = now.model.images.size();
  now.attempts.push_back(std::move(attempt));
  mark_registered(now);
}

Reconstruction mapped_with_cameras(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc,
                                   const Reconstruction& found, std::span<const CameraOfPhotos> cameras, const fs::path& folder) {
  if (ColmapDatabase(found.database).has_frames()) {
    ReconstructDesc again = desc;
    again.work_folder = folder;
    for (size_t c = 0; c < cameras.size(); ++c)
      for (const size_t i : cameras[c].photos) {
        again.photos[i].camera = fmt::format("{}", c);
        again.photos[i].focal_px = cameras[c].trusted ? std::optional(cameras[c].start.params[0]) : std::nullopt;
      }
    return reconstruct(colmap, config, again);
  }
  make_folders(folder);
  Reconstruction now = found;
  now.model = {}, now.smaller_models = {};
  now.database = folder / "cameras.db";
  fs::copy_file(found.database, now.database, fs::copy_options::overwrite_existing);
  std::map<size_t, size_t> camera_of_photo;
  std::vector<ColmapCamera> starts;
  std::vector<bool> trusted;
  for (size_t c = 0; c < cameras.size(); ++c) {
    starts.push_back(cameras[c].start), trusted.push_back(cameras[c].trusted);
    for (const size_t i : cameras[c].photos) camera_of_photo[i] = c;
  }
  std::vector<std::pair<uint32_t, size_t>> camera_of_image;
  ColmapDatabase database(now.database);
  for (const PhotoFeatures& f : database.features())
    if (const std::optional<size_t> i = index_of_safe_name(f.name); i && camera_of_photo.contains(*i))
      camera_of_image.push_back({f.image_id, camera_of_photo.at(*i)});
  database.replace_cameras(starts, trusted, camera_of_image);
  for (PhotoReport& p : now.photos) p.registered = false, p.observations = 0, p.weak_points.reset();
  Attempt attempt{.what = fmt::format("{} cameras by focal length", cameras.size()), .model_sizes = {}};
  attempt.model_sizes = run_mapper(colmap, config, desc, {.what = {}, .relaxed_mapper = found.relaxed}, folder / "models", now);
  finish_attempt(now, std::move(attempt));
  // Photos without a pose leave cameras behind.
  std::erase_if(now.model.cameras, [&](const ColmapCamera& camera) {
    return std::ranges::none_of(now.model.images, [&](const ColmapImage& image) { return image.camera_id == camera.id; });
  });
  return now;
}

}  // namespace vitrine
