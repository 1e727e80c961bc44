#include "stages/normals/normals.h"

#include <algorithm>
#include <functional>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/timer.h"
#include "core/intake/depth/depth_files.h"
#include "core/observe/stereo/known_depth.h"
#include "core/scene/image/exr.h"
#include "stages/normals/geometric.h"
#include "stages/normals/given_depth.h"
#include "stages/normals/space.h"
#include "stages/training_cost.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kSpaceViews = 4;           // photos used to detect the frame
constexpr double kSuspectAway = 0.05;       // share of normals facing away from the camera that causes a warning
constexpr double kWrongAway = 0.5;          // share that proves a wrong frame
constexpr float kNetworkConfidence = 0.7f;  // factor on the confidence of a network
constexpr float kGlassConfidence = 0.5f;    // additional factor on glass

class NormalsRun {
 public:
  NormalsRun(const NormalsConfig& config, StageContext& context)
      : config_(config),
        context_(context),
        capture_(load_normal_capture(context.input("sfm"), context.optional_input("objects"), config.holdout_every)),
        folder_(context.optional_input("normals")),
        network_(context.optional_input("network")) {}

  void run() {
    const NormalSource source = chosen_source();
    report_["source"] = kNormalSourceWords[size_t(source)];
    if (const auto depth = context_.optional_input("depth")) given_depths(*depth);
    if (source == NormalSource::Geometric) geometric();
    if (source == NormalSource::Files) files();
    if (source == NormalSource::Onnx) onnx();
    finish(source);
  }

 private:
  NormalSource chosen_source() const {
    if (config_.source != NormalSource::Auto) return config_.source;
    if (folder_) return NormalSource::Files;
    return network_ ? NormalSource::Onnx : NormalSource::Geometric;
  }

  std::vector<uint32_t> all_views() const {
    std::vector<uint32_t> views;
    for (uint32_t v = 0; v < capture_.set.views.size(); ++v) views.push_back(v);
    return views;
  }

  // Writes the user's depth maps in scene units; stereo takes them where they agree with each other.
  void given_depths(const fs::path& folder) {
    Notes notes;
    auto given = given_depth(folder, context_.input("sfm"), capture_.set, config_.max_side, notes);
    for (const Note& note : notes) context_.warning(note.code, note.text);
    report_["depth"] = {{"used", given.has_value()}};
    if (!given) return;
    report_["depth"] = {{"used", true},
                        {"photos", given->photos},
                        {"photos_of_other_scale", given->other_scale},
                        {"sparse_points", given->ratios},
                        {"units_per_metre", given->units_per_metre},
                        {"scale_from", given->from_frame ? "poses" : "sparse points"},
                        {"spread", given->spread}};
    context_.metric("depth_maps", double(given->photos));
    log_info("depth maps of {} photos: 1 m of theirs is {:.4g} units of the scene ({} sparse points, spread {:.1f} %)",
             given->photos, given->units_per_metre, given->ratios, 100 * given->spread);
    for (uint32_t v : all_views()) {
      if (given->maps[v].empty()) continue;
      const fs::path file = known_depth_path(context_.output(), capture_.set.views[v]);
      make_folders(file.parent_path());
      write_exr(file, {.pixels = given->maps[v], .channels = {"Z"}, .attributes = {}}, ExrPrecision::Float);
    }
    capture_.depth = std::move(given->maps);
  }

  void geometric() {
    size_t alone = 0;
    const auto views = all_views();
    std::vector<NormalMap> maps = geometric_normals(
        {.capture = capture_, .max_side = config_.geometric.max_side, .views = views},
        [&](double f) { context_.progress({.fraction = 0.95 * f, .text = "normals from stereo", .values = {}}); }, &alone);
    for (uint32_t v : views)
      if (!maps[v].empty()) write(v, std::move(maps[v]));
    if (alone > 0) context_.warning("NO_STEREO", fmt::format("{} photos share no view with others", alone));
  }

  void files() {
    if (!folder_)
      throw Error(ErrorKind::Usage, "normals.source is 'files' and no folder of normal maps is given",
                  {.where = "stage 'normals'", .hint = "--set input.normals=DIR", .code = "MISSING_INPUT"});
    std::vector<std::optional<fs::path>> found;
    for (const View& view : capture_.set.views) found.push_back(find_normal_file(*folder_, view));
    std::vector<uint32_t> views;
    for (uint32_t v = 0; v < found.size(); ++v)
      if (found[v]) views.push_back(v);
    if (views.empty())
      throw Error(ErrorKind::Input, "no normal map belongs to a photo",
                  {.where = folder_->string(),
                   .why = fmt::format("looked for {0}.exr, {0}.png, {0}_normal.png and the like",
                                      capture_.set.views.empty() ? std::string("<photo>") : capture_.set.views[0].stem()),
                   .hint = "name them like the photos in images/",
                   .code = "NO_NORMAL_FILES"});
    if (views.size() < found.size())
      context_.warning("NORMALS_MISSING",
                       fmt::format("{} of {} photos have no normal map", found.size() - views.size(), found.size()));
    const auto map_of = [&](uint32_t v) { return read_normal_file(*found[v], capture_.set.views[v]); };
    const NormalSpace space = chosen_space(config_.files.space, views, map_of, folder_->string());
    given_maps(views, map_of, space, 1, folder_->string());
  }

  void onnx() {
    const OnnxConfig config = network_ ? config_.onnx : built_in_network_config();
    NormalNetwork network(network_, config);
    report_["network"] = {{"built_in", network.built_in()}, {"sha256", network.sha256()}};
    const auto map_of = [&](uint32_t v) {
      const Intrinsics& k = capture_.set.views[v].intrinsics;
      const auto [w, h] = network.input_size(k.width, k.height);
      NormalMap map = network.predict(capture_.photo(v, w, h));
      // Predictors are less accurate on glass than on painted surfaces.
      const View& view = capture_.set.views[v];
      const ImageF glass = capture_.objects.coverage(view, view.intrinsics.scaled_to(map.normal.width(), map.normal.height()),
                                                     [](const Object& o) { return is_glass(o.role); });
      for (size_t i = 0; i < glass.data().size(); ++i) map.confidence.data()[i] *= 1 + glass.data()[i] * (kGlassConfidence - 1);
      return map;
    };
    const std::string what = network_ ? network_->string() : "the network that is built in";
    const NormalSpace space = chosen_space(config.space, all_views(), map_of, what);
    given_maps(all_views(), map_of, space, kNetworkConfidence, what);
  }

  // The declared frame, or the one detected on a few photos.
  NormalSpace chosen_space(const std::string& declared, const std::vector<uint32_t>& views,
                           const std::function<NormalMap(uint32_t)>& map_of, const std::string& what) {
    Json& j = report_["space"];
    if (declared != "auto") {
      j = {{"name", declared}, {"declared", true}};
      return normal_space(declared);
    }
    std::vector<uint32_t> chosen;
    const size_t count = std::min(kSpaceViews, views.size());
    for (size_t i = 0; i < count; ++i) chosen.push_back(views[(2 * i + 1) * views.size() / (2 * count)]);
    const std::vector<NormalMap> geometric = geometric_normals(
        {.capture = capture_, .max_side = config_.geometric.max_side, .views = chosen, .with_objects = false},
        [&](double f) { context_.progress({.fraction = 0.3 * f, .text = "which frame the normals are in", .values = {}}); });
    std::vector<NormalMap> given;
    std::vector<View> sized;
    for (size_t i = 0; i < count; ++i) {
      sized.push_back(capture_.set.views[chosen[i]]);
      sized[i].intrinsics = sized[i].intrinsics.limited_to(config_.geometric.max_side);
      given.push_back(resized(map_of(chosen[i]), sized[i].intrinsics.width, sized[i].intrinsics.height));
    }
    std::vector<SpaceSample> samples;
    for (size_t i = 0; i < count; ++i)
      if (!geometric[i].empty()) samples.push_back({given[i], geometric[i], sized[i]});
    const auto candidates = detected_space(samples, what);
    j = {{"name", candidates[0].space.name()}, {"declared", false}, {"candidates", Json::array()}};
    for (const SpaceCandidate& c : candidates)
      j["candidates"].push_back({{"name", c.space.name()}, {"error_deg", c.error_deg}, {"facing", c.facing}});
    log_info("normals: the frame is {} ({:.1f} degrees off the photos' geometry; next {}, {:.1f})", candidates[0].space.name(),
             candidates[0].error_deg, candidates[1].space.name(), candidates[1].error_deg);
    return candidates[0].space;
  }

  // Processes external maps: conversion to the camera frame, check, resize, output.
  void given_maps(const std::vector<uint32_t>& views, const std::function<NormalMap(uint32_t)>& map_of, const NormalSpace& space,
                  float confidence, const std::string& what) {
    Facing facing;
    for (size_t i = 0; i < views.size(); ++i) {
      throw_if_interrupted();
      const View& view = capture_.set.views[views[i]];
      NormalMap map = map_of(views[i]);
      for (float& c : map.confidence.data()) c *= confidence;
      to_camera(map, space, view.cam_from_world);
      const Facing f = forget_hidden_sides(map, view.intrinsics.scaled_to(map.normal.width(), map.normal.height()));
      facing.known += f.known, facing.away += f.away;
      write(views[i], std::move(map));
      context_.progress(
          {.fraction = 0.3 + 0.65 * double(i + 1) / double(views.size()), .text = "normals of photos", .values = {}});
    }
    const double away = facing.known > 0 ? double(facing.away) / double(facing.known) : 0;
    report_["facing_away"] = away;
    if (away > kWrongAway)
      throw Error(ErrorKind::Input, "the normals look away from the camera",
                  {.where = what,
                   .why = fmt::format("{:.0f} % of them do in the frame {}", 100 * away, space.name()),
                   .hint = "declare the frame they are in, or 'auto'",
                   .code = "NORMALS_FACE_AWAY"});
    if (away > kSuspectAway)
      context_.warning("NORMALS_FACE_AWAY",
                       fmt::format("{:.0f} % of the normals look away from the camera and were dropped", 100 * away));
  }

  void write(uint32_t v, NormalMap map) {
    const View& view = capture_.set.views[v];
    const Intrinsics k =
        view.intrinsics.limited_to(std::min(config_.max_side, std::max(map.normal.width(), map.normal.height())));
    map = resized(map, k.width, k.height);
    double known = 0, sure = 0;
    for (float c : map.confidence.data()) known += c > 0, sure += double(c);
    const double pixels = double(map.confidence.pixel_count());
    write_normal_map(context_.output() / "normals", view, map);
    photos_.push_back({{"name", view.name},
                       {"width", k.width},
                       {"height", k.height},
                       {"known", known / pixels},
                       {"mean_confidence", known > 0 ? sure / known : 0.0}});
    known_ += known / pixels;
    sure_ += known > 0 ? sure / known : 0;
  }

  void finish(NormalSource source) {
    report_["photos"] = photos_;
    make_folders(context_.output() / "normals");
    write_file(context_.output() / "normals" / "report.json", report_.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
    context_.metric("maps", double(photos_.size()));
    if (photos_.empty()) {
      context_.summary(source == NormalSource::None ? "none wanted" : "none");
      return;
    }
    const double known = known_ / double(photos_.size()), sure = sure_ / double(photos_.size());
    context_.metric("known", known);
    context_.metric("confidence", sure);
    std::string space = report_.contains("space") ? ", " + report_["space"]["name"].get<std::string>() : std::string();
    context_.summary(fmt::format("{}{}: {} maps, {:.0f} % of the pixels, confidence {:.2f}", kNormalSourceWords[size_t(source)],
                                 space, photos_.size(), 100 * known, sure));
  }

  const NormalsConfig& config_;
  StageContext& context_;
  NormalCapture capture_;
  std::optional<fs::path> folder_, network_;
  Json report_, photos_ = Json::array();
  double known_ = 0, sure_ = 0;
};

void describe_space(Describer& d, std::string& space) {
  std::vector<std::string> names = normal_space_names();
  names.insert(names.begin(), "auto");
  d.option("space", space, "Frame of the normals; auto = found by comparing with the photos' geometry.").choices(names);
}

std::string config_problem(const NormalsConfig& c) { return c.onnx.input.problem("onnx."); }

}  // namespace

void describe(Describer& d, GeometricConfig& c) {
  d.option("max_side", c.max_side, "Longest side at which the photos are matched, pixels.").range(32, 4096);
}

void describe(Describer& d, NormalFilesConfig& c) { describe_space(d, c.space); }

void describe(Describer& d, OnnxConfig& c) {
  describe_space(d, c.space);
  describe_input(d, c.input);
  d.choice("output", c.output, {"vector", "rgb"}, "vector: the normal itself; rgb: (n + 1) / 2.");
  d.choice("doubt", c.doubt, {"smoothness", "kappa"},
           "Where the confidence comes from: a fourth channel kappa, or how smooth the normals are.");
}

void describe(Describer& d, NormalsConfig& c) {
  d.choice("source", c.source, kNormalSourceWords,
           "Where normals come from; auto = files or onnx where such an input is given, else geometric.");
  d.option("max_side", c.max_side, "Longest side of the written maps, pixels; what is known more coarsely stays so.")
      .range(16, 16384);
  d.option("holdout_every", c.holdout_every,
           "Every how many photos one is kept for the evaluation and helps no other one; as optimize.holdout_every.")
      .range(0, 100000);
  d.group("geometric", c.geometric, "Normals from stereo between the photos.");
  d.group("files", c.files, "Normal maps of your own.");
  d.group("onnx", c.onnx, "Input and output of the network given as input.network; those of the one that is built in are known.");
}

void run_normals(const NormalsConfig& config, StageContext& context) { NormalsRun(config, context).run(); }

Stage normals_stage() {
  StageInfo info{.name = "normals",
                 .version = 8,
                 .summary = "surface normals of the photos, from stereo, files or a network",
                 .inputs = {{.name = "sfm", .doc = "cameras, sparse points and undistorted photos"},
                            {.name = "objects", .optional = true, .doc = "glass, mirrors and coats: labels and shapes"},
                            {.name = "normals",
                             .artifact = false,
                             .optional = true,
                             .doc = "normal maps of the photos: <stem>.png or <stem>.exr"},
                            {.name = "depth",
                             .artifact = false,
                             .optional = true,
                             .doc = "depth maps of the photos: <stem>.png of 16 bit or <stem>.exr, or a transforms.json",
                             .also = files_of_depth_list},
                            {.name = "network",
                             .artifact = false,
                             .optional = true,
                             .doc = "a network that predicts normals from a photo (ONNX)"}},
                 .doing = "estimating surfaces",
                 .cost = normals_cost,
                 .report = normals_report()};
  return make_stage<NormalsConfig>(
      std::move(info), run_normals,
      [] {
        return std::map<std::string, std::string>{{"network", built_in_network_sha256().substr(0, 16)}};
      },
      config_problem);
}

StageCost normals_cost(const CostTerms& t) {
  const double out = t.photos() * t.mpx(t.limited("normals.max_side", ingested_side(t)));
  const double stereo = t.photos() * t.mpx(t.limited("normals.geometric.max_side", ingested_side(t)));
  return stage_cost(0.6 * t.photos() + 22 * stereo, 0.95, 90 + 4 * out, 1.2 * out);
}

StageReport normals_report() {
  StageReport report{.file = "normals/report.json"};
  report.figures = {ReportFigure{"Geometry", "normals_known", "Surface known before training", "%", 0, 0.6, 0.3,
                                 "Share of the pixels with a normal from stereo, hulls, files or a network.",
                                 "Training begins with little knowledge of the surface: plain or shiny areas.", "photos.*.known"}
                        .folded("mean")
                        .noted("source: {source}")};
  return report;
}

}  // namespace vitrine
