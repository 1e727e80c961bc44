#include "pipeline/report_page/figures.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/math/median.h"
#include "pipeline/report_page/facts.h"

namespace vitrine {

namespace {

// What a figure was measured on. Below these numbers it is shown, but says nothing about good or bad.
constexpr double kFewestPoints = 100;  // sparse points: what poses and their error hang on
constexpr double kFewestViews = 2;     // one picture may be the best or the worst
constexpr double kFewestAligned = 5;   // cameras: three always fit the truth after an alignment

struct Samples {
  std::optional<double> have;  // nullopt: the report does not say, the figure is believed
  double fewest = 0;
  const char* of = "";  // "points"
  bool few() const { return have && *have < fewest; }
};

class Group {
 public:
  explicit Group(std::string title) { group_.title = std::move(title); }
  void add(std::string_view id, std::optional<double> value, std::string note = {}, const Samples& samples = {}) {
    if (!value) return;
    const Rule& r = rule(id);
    Figure f{.rule = &r, .value = *value, .rating = Rating::Unknown, .note = std::move(note), .unknown = {}};
    if (samples.few())
      f.unknown = fmt::format("too few {} ({:.0f})", samples.of, *samples.have);
    else
      f.rating = rate(r, *value);
    group_.figures.push_back(std::move(f));
  }
  void into(std::vector<FigureGroup>& groups) && {
    if (!group_.figures.empty()) groups.push_back(std::move(group_));
  }

 private:
  FigureGroup group_;
};

// Why a photo has no pose; sfm's word for the likely cause (stages/sfm/README.md) in words.
std::string reason_of(const Facts& photo) {
  constexpr std::pair<std::string_view, std::string_view> kCauses[] = {
      {"mixed_exposure", "much brighter or darker than the others"},
      {"motion_blur", "blurred"},
      {"too_few_features", "too little texture"},
      {"split_models", "part of another group of photos"},
      {"reflections_dominate", "mostly reflections"},
      {"no_overlap", "too little in common with the others"}};
  const std::string reason = photo.text("reason"), cause = photo.text("cause");
  for (const auto& [name, words] : kCauses)
    if (name == cause) return reason.empty() ? std::string(words) : fmt::format("{} (likely: {})", reason, words);
  return reason;
}

std::vector<PhotoPose> read_photos(const Facts& sfm) {
  std::vector<PhotoPose> photos;
  for (const Facts& p : sfm.at("photos").items())
    photos.push_back({.name = p.text("name"),
                      .reason = reason_of(p),
                      .registered = p.boolean("registered").value_or(false),
                      .features = p.number("features").value_or(0),
                      .matches = p.number("verified_matches").value_or(0),
                      .observations = p.number("observations").value_or(0)});
  return photos;
}

std::vector<PhotoScore> read_views(const fs::path& project) {
  constexpr std::string_view kPrefix = "psnr_";
  std::vector<PhotoScore> views;
  for (const auto& row : rows_of_csv(text_of_file(project / "eval/per_view.csv"))) {
    const auto cell = [&](const char* name) {
      const auto found = row.find(name);
      return found == row.end() ? std::string() : found->second;
    };
    const auto psnr = number_of(cell("psnr"));
    if (!psnr || cell("name").empty()) continue;
    PhotoScore& v = views.emplace_back();
    v.name = cell("name");
    v.heldout = cell("set") == "heldout";
    v.psnr = *psnr;
    v.ssim = number_of(cell("ssim"));
    for (const auto& [key, text] : row)
      if (const auto region = number_of(text); region && key.starts_with(kPrefix))
        v.regions[key.substr(kPrefix.size())] = *region;
  }
  return views;
}

void add_poses(const Facts& sfm, Figures& f) {
  Group group("Photos and poses");
  const auto registered = sfm.number("registered"), count = sfm.number("photo_count");
  const Samples points{sfm.number("points.kept"), kFewestPoints, "points"};
  if (registered && count && *count > 0)
    group.add("registered", *registered / *count, fmt::format("{:.0f} of {:.0f}", *registered, *count), points);
  // Without a point there is no error; the figure stays to say so.
  const std::optional<double> error = sfm.number("mean_reprojection_error_px");
  const bool none = points.have && *points.have <= 0;
  group.add("reprojection", none ? std::optional(std::nan("")) : error, {}, points);
  std::vector<double> observations;
  for (const PhotoPose& p : f.photos)
    if (p.registered) observations.push_back(p.observations);
  if (!observations.empty()) group.add("observations", upper_median(observations));
  std::move(group).into(f.groups);
}

void add_views(const Facts& metrics, Figures& f) {
  Group group("Pictures from new places");
  const auto psnr = metrics.number("heldout.psnr"), train = metrics.number("train.psnr");
  const auto views = metrics.number("heldout.views");
  const Samples heldout{views, kFewestViews, "held-out views"};
  group.add("psnr", psnr, views ? fmt::format("{:.0f} view{} held out of training", *views, *views == 1 ? "" : "s") : "",
            heldout);
  group.add("ssim", metrics.number("heldout.ssim"), {}, heldout);
  if (psnr && train)
    group.add("gap", *train - *psnr, fmt::format("{:.1f} dB where it trained, {:.1f} dB where not", *train, *psnr), heldout);
  const PhotoScore* weakest = nullptr;
  for (const PhotoScore& v : f.views)
    if (v.heldout && (weakest == nullptr || v.psnr < weakest->psnr)) weakest = &v;
  if (psnr && weakest != nullptr && views.value_or(0) > 1)
    group.add("weakest", std::max(0.0, *psnr - weakest->psnr), fmt::format("{}: {:.1f} dB", weakest->name, weakest->psnr));
  std::move(group).into(f.groups);
}

void add_regions(const Facts& metrics, Figures& f) {
  Group group("Parts of the picture");
  for (const char* region : {"transparent", "reflective", "object", "rest"})
    if (const Facts r = metrics.at("regions").member(region); r.known())
      group.add(fmt::format("region_{}", region), r.number("psnr"), {}, {r.number("views"), kFewestViews, "held-out views"});
  std::move(group).into(f.groups);
}

void add_geometry(const Facts& normals, const Facts& mesh, Figures& f) {
  Group group("Geometry");
  std::vector<double> known;
  for (const Facts& p : normals.at("photos").items())
    if (const auto k = p.number("known")) known.push_back(*k);
  if (!known.empty()) {
    double sum = 0;
    for (double k : known) sum += k;
    group.add("normals_known", sum / double(known.size()), fmt::format("source: {}", normals.text("source")));
  }
  const Samples faces{mesh.number("mesh.faces"), 1, "triangles"};
  const auto edges = mesh.number("mesh.edges"), border = mesh.number("mesh.boundary_edges");
  if (edges && border && *edges > 0) group.add("mesh_border", *border / *edges);
  group.add("mesh_crossing", mesh.number("mesh.self_intersections"), {}, faces);
  group.add("mesh_nonmanifold", mesh.number("mesh.nonmanifold_edges"), {}, faces);
  std::move(group).into(f.groups);
}

void add_light(const Facts& relight, Figures& f) {
  Group group("Light and materials");
  group.add("baked", relight.number("baked_log_rms"));
  if (const auto rounds = relight.at("misfit_log_rms").items(); !rounds.empty()) group.add("misfit", rounds.back().number());
  std::move(group).into(f.groups);
}

void add_truth(const Facts& metrics, Figures& f) {
  Group group("Against the truth");
  const Facts truth = metrics.at("truth");
  const Samples aligned{truth.number("pose.views_in_alignment"), kFewestAligned, "cameras to align"};
  group.add("truth_rotation", truth.number("pose.rotation_deg"), {}, aligned);
  group.add("truth_centre", truth.number("pose.centre_rel"), {}, aligned);
  group.add("truth_normals", truth.number("normal_mae_deg"));
  group.add("truth_depth", truth.number("depth_rel"));
  group.add("truth_fscore", truth.number("mesh.fscore"));
  group.add("truth_transmitted", truth.number("transmitted.psnr"), {},
            {truth.number("transmitted.views"), kFewestViews, "views with a truth"});
  group.add("truth_albedo", truth.number("albedo.psnr"), {}, {truth.number("albedo.views"), kFewestViews, "views with a truth"});
  group.add("truth_relit", truth.number("relit.psnr"));
  std::move(group).into(f.groups);
}

std::string counted(double n, std::string_view what) {
  std::string digits = fmt::format("{:.0f}", n);
  for (ptrdiff_t at = ptrdiff_t(digits.size()) - 3; at > 0; at -= 3) digits.insert(size_t(at), "\u202f");  // narrow space
  return fmt::format("{} {}", digits, what);
}

void add_facts(const Facts& sfm, const Facts& training, const Facts& mesh, const Facts& metrics, Figures& f) {
  if (const auto points = sfm.number("points.kept")) f.facts.push_back(counted(*points, "sparse points"));
  if (const auto surfels = training.number("surfels")) {
    std::string parts;
    double all = 0;
    for (const std::string& layer : training.at("layers").keys())
      if (const auto n = training.at("layers").member(layer).number("surfels"))
        parts += (parts.empty() ? "" : ", ") + counted(*n, layer), all += *n;
    const bool several = training.at("layers").keys().size() > 1;
    f.facts.push_back(counted(several ? all : *surfels, "surfels") + (several ? fmt::format(" (by layer: {})", parts) : ""));
  }
  if (const auto all = metrics.number("surfels"); all && !training.number("surfels")) f.facts.push_back(counted(*all, "surfels"));
  if (const auto steps = training.number("iterations")) f.facts.push_back(counted(*steps, "training steps"));
  const auto width = metrics.number("resolution.width"), height = metrics.number("resolution.height");
  if (width && height) f.facts.push_back(fmt::format("pictures of {:.0f} × {:.0f}", *width, *height));
  const auto faces = mesh.number("mesh.faces"), pieces = mesh.number("mesh.components");
  if (faces && pieces)
    f.facts.push_back(
        fmt::format("a mesh of {} in {}", counted(*faces, "triangles"), counted(*pieces, *pieces == 1 ? "piece" : "pieces")));
}

// What the refine stage found out about the largest piece of closed glass.
void add_glass(const Facts& refine, Figures& f) {
  for (const Facts& region : refine.at("glass.regions").items()) {
    const std::string verdict = region.text("verdict");
    const auto straight = region.number("psnr.straight"), straight_without = region.number("psnr.straight_without_layer");
    const auto bent = region.number("psnr.bent"), bent_without = region.number("psnr.bent_without_layer");
    if ((verdict != "thin" && verdict != "thick") || !straight || !straight_without || !bent || !bent_without) continue;
    f.facts.push_back(
        fmt::format("the glass looks {} (straight rays show what is behind it at {:.1f} dB, refracted ones at {:.1f} dB)",
                    verdict, std::max(*straight, *straight_without), std::max(*bent, *bent_without)));
    return;
  }
}

}  // namespace

const Figure* Figures::find(std::string_view id) const {
  for (const FigureGroup& group : groups)
    for (const Figure& figure : group.figures)
      if (figure.rule->id == id) return &figure;
  return nullptr;
}

Figures gather_figures(const fs::path& project, const RunOutcome& outcome) {
  const Facts sfm = Facts::of_file(outcome.sfm_report), training = Facts::of_file(project / "optimize/report.json"),
              normals = Facts::of_file(project / "normals/report.json"), mesh = Facts::of_file(project / "mesh/report.json"),
              relight = Facts::of_file(project / "relight/report.json"), metrics = Facts::of_file(project / "eval/metrics.json");
  Figures f;
  f.photos = read_photos(sfm);
  f.views = read_views(project);
  add_poses(sfm, f);
  add_views(metrics, f);
  add_regions(metrics, f);
  add_geometry(normals, mesh, f);
  add_light(relight, f);
  add_truth(metrics, f);
  add_facts(sfm, training, mesh, metrics, f);
  add_glass(Facts::of_file(project / "refine/report.json"), f);
  return f;
}

}  // namespace vitrine
