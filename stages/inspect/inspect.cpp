#include "stages/inspect/inspect.h"

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/intake/film/photos_and_films.h"
#include "core/intake/depth/depth_files.h"
#include "core/intake/masks/mask_files.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "stages/inspect/coverage.h"
#include "stages/inspect/findings.h"
#include "stages/inspect/given_masks.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormat = 1;  // of inspect/report.json

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

Json photo_json(const PhotoFacts& p) {
  Json j{{"name", p.name}};
  if (!p.usable()) {
    j["failure"] = p.failure;
    return j;
  }
  const PhotoMeasures& m = p.measures;
  j["width"] = p.width;
  j["height"] = p.height;
  j["camera"] = p.camera;
  j["time"] = p.time;
  j["color_profile"] = p.color.profile;
  j["color_source"] = p.color.source;
  j["alpha"] = p.color.alpha;
  j["focal_px"] = or_null(p.focal_px);
  j["exposure_ev"] = or_null(p.exposure_ev);
  j["blur_px_at_1600"] = or_null(p.blur());
  j["blur_ratio"] = m.blur_ratio;
  j["texture"] = m.texture;
  j["clipped_high"] = m.clipped_high;
  j["clipped_low"] = m.clipped_low;
  j["brightness_ev"] = m.brightness_ev;
  j["red_green"] = m.red_green;
  j["blue_green"] = m.blue_green;
  return j;
}

Json finding_json(const Finding& f, const std::vector<PhotoFacts>& photos) {
  Json names = Json::array();
  for (size_t i : f.photos) names.push_back(photos[i].name);
  return {{"code", f.code}, {"severity", std::string(name(f.severity))},
          {"what", f.what}, {"why", f.why},
          {"try", f.hint},  {"photos", std::move(names)}};
}

Json figures_json(const SetFigures& f, const std::vector<PhotoFacts>& photos) {
  uint64_t pixels = 0;
  for (const PhotoFacts& p : photos) pixels += uint64_t(p.width) * uint64_t(p.height);
  return {{"photos", photos.size()},
          {"usable", f.usable},
          {"pixels", pixels},
          {"blur_px_at_1600", or_null(f.blur)},
          {"texture", f.texture},
          {"clipped_high", f.clipped_high},
          {"clipped_low", f.clipped_low},
          {"brightness_range_ev", f.brightness_range_ev},
          {"exposure_range_ev", or_null(f.exposure_range_ev)},
          {"white_balance_range", or_null(f.white_balance_range)}};
}

Json coverage_json(const Coverage& c) {
  Json gaps = Json::array();
  for (const RingGap& g : c.gaps)
    gaps.push_back({{"from_deg", g.from_deg},
                    {"to_deg", g.to_deg},
                    {"width_deg", g.width_deg()},
                    {"from", g.from},
                    {"to", g.to},
                    {"photos_to_add", g.photos_to_add}});
  return {{"cameras", c.cameras},       {"inward", c.inward},           {"centre", {c.centre.x, c.centre.y, c.centre.z}},
          {"lowest_deg", c.lowest_deg}, {"highest_deg", c.highest_deg}, {"points_seen_by_two", c.thin_points},
          {"gaps", std::move(gaps)}};
}

// Machine-readable summary: good, usable (warnings), poor (problems).
std::string verdict(const std::vector<Finding>& list) {
  const Severity worst = list.empty() ? Severity::Note : list.front().severity;
  return worst == Severity::Problem ? "poor" : worst == Severity::Warning ? "usable" : "good";
}

void add_films(const PhotosAndFilms& all, std::vector<Finding>& list) {
  for (const FilmReport& film : all.films)
    list.push_back({film.failure.empty() ? "film_frames" : "film_left_out",
                    film.failure.empty() && film.damage.empty() ? Severity::Note : Severity::Warning, film.sentence(),
                    fmt::format("the sharpest frame of each part, at least {:.0f} % of the picture apart", 100 * all.least_motion),
                    film.failure.empty() ? "--frames N limits their number; a run cuts the film again" : "take it out, or film again",
                    {}});
  worst_first(list);
}

void run(const InspectConfig& config, StageContext& context) {
  const TemporaryFolder work("vitrine-films");
  const PhotosAndFilms all =
      photos_and_films(context.input("photos"), {.most_frames = size_t(config.frames),
                                                 .work = work.path(),
                                                 .progress = [&](double fraction, const std::string& text) {
                                                   context.progress({.fraction = fraction, .text = text, .values = {}});
                                                 }});
  const PhotoFolder& folder = all.folder;
  const size_t n = folder.photos.size();
  const std::vector<PhotoFacts> photos = photo_facts(folder, [&](size_t done) {
    context.progress({.fraction = double(done) / double(n), .text = fmt::format("{} / {} photos", done, n), .values = {}});
  });
  Findings found = findings_of(folder, photos, config.soft_ratio);
  if (found.figures.usable == 0)
    throw Error(ErrorKind::Input, "none of the photos can be read",
                {.where = context.input("photos").string(),
                 .why = fmt::format("{}: {}", photos[0].name, photos[0].failure),
                 .hint = "give the folder that holds the photos: JPEG, PNG, TIFF, EXR",
                 .code = "NO_PHOTOS"});
  add_films(all, found.list);
  if (const auto masks = context.optional_input("masks")) {
    const std::vector<Finding> more = mask_findings(*masks, photos);
    found.list.insert(found.list.end(), more.begin(), more.end());
    worst_first(found.list);
  }
  if (const auto depth = context.optional_input("depth")) {
    const std::vector<Finding> more = depth_findings(*depth, photos);
    found.list.insert(found.list.end(), more.begin(), more.end());
    worst_first(found.list);
  }
  Json report{{"format", kFormat}, {"verdict", verdict(found.list)}, {"set", figures_json(found.figures, photos)}};
  report["findings"] = Json::array();
  for (const Finding& f : found.list) report["findings"].push_back(finding_json(f, photos));
  if (const auto sfm = context.optional_input("sfm")) {
    report["coverage"] = coverage_json(coverage(load_view_set(*sfm)));
    if (const std::string passes = passes_summary(*sfm); !passes.empty()) report["passes"] = passes;
  }
  report["photos"] = Json::array();
  for (const PhotoFacts& p : photos) report["photos"].push_back(photo_json(p));
  make_folders(context.output() / "inspect");
  write_file(context.output() / "inspect" / "report.json", report.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  context.summary(fmt::format("{} photos, {}", n, verdict(found.list)));
}

}  // namespace

void describe(Describer& d, InspectConfig& c) {
  d.option("soft_ratio", c.soft_ratio, "A photo is called soft when its blur is so many times that of its neighbours.")
      .range(1, 20);
  d.option("frames", c.frames, "Most frames that become photos, of all films together, as ingest.frames.").range(2, 2000);
}

Stage inspect_stage() {
  return make_stage<InspectConfig>(
      {.name = "inspect",
       .version = 3,
       .summary = "What a folder of photos promises: blur, exposure, duplicates, texture; after sfm, gaps between the cameras.",
       .inputs = {{.name = "photos", .artifact = false, .optional = false, .doc = "Folder of photos: JPEG, PNG, TIFF, EXR, HEIC, AVIF, raw; films in it, or one film."},
                  {.name = "sfm", .optional = true, .doc = "artifact of sfm: where the cameras stand"},
                  {.name = "masks",
                   .artifact = false,
                   .optional = true,
                   .doc = "masks that the run will be given",
                   .also = files_of_mask_list},
                  {.name = "depth",
                   .artifact = false,
                   .optional = true,
                   .doc = "depth maps that the run will be given",
                   .also = files_of_depth_list}}},
      &run);
}

}  // namespace vitrine
