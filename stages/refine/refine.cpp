#include "stages/refine/refine.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/json_file.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/refine/glass_views.h"
#include "stages/refine/thickness.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMapLevel = 1;            // pyramid level: segments at half size
constexpr double kMostMotionVoxels = 0.5;  // largest displacement of glass from its mesh without visible effect
constexpr double kLeastGain = 0.01;        // dB in glass of held-out photos; with less, the scene is unchanged
constexpr double kMostLoss = 0.005;        // dB of whole photos: tolerated noise
constexpr float kLeastAgreement = 0.8f;    // share of a photo's glass with consistent mesh and rendered depth
constexpr const char* kGlassWords[] = {"auto", "thin", "thick"};

Json json_of(const Quality& q) { return {{"glass", rounded(q.glass)}, {"rest", rounded(q.rest)}, {"all", rounded(q.all)}}; }

// Voxel edge length of the mesh.
float voxel_of(const fs::path& mesh) {
  double voxel = 0;
  read_json_file(mesh / "mesh" / "grid.json", "grid of the mesh", [&](const nlohmann::json& j) {
    voxel = JsonAt(j).at("voxel").number();
    if (!(voxel > 0)) throw JsonMistake("/voxel", "voxel: expected a length");
  });
  return static_cast<float>(voxel);
}

struct Candidate {
  std::string name, what;
  TrainedScene scene;
  Quality heldout = {};
};

// The selected photos, with the train/held-out split of the training.
Capture capture_of(const RefineConfig& config, const StageContext& context) {
  const fs::path optimize = context.input("optimize");
  const ViewSplit split = read_view_split(optimize / "optimize" / "views.json", load_view_set(context.input("sfm")).views);
  Capture capture = load_capture(context.input("sfm"),
                                 config.max_side > 0  ? config.max_side
                                 : split.max_side > 0 ? split.max_side
                                                      : 16384,
                                 0);
  use_corrected_poses(optimize, capture);
  capture.train.assign(split.train.begin(), split.train.end());
  capture.heldout.assign(split.heldout.begin(), split.heldout.end());
  if (capture.train.empty())
    throw Error(ErrorKind::Input, "the scene was trained on no photo",
                {.where = (optimize / "optimize" / "views.json").string(),
                 .why = "all its views are held out",
                 .hint = "run the optimize stage again",
                 .code = "NO_TRAINING_VIEW"});
  return capture;
}

class Refiner {
 public:
  Refiner(const RefineConfig& config, StageContext& context, TrainedScene scene)
      : config_(config),
        context_(context),
        scene_(std::move(scene)),
        capture_(capture_of(config, context)),
        objects_(LabelledObjects::trusted(context.optional_input("objects"))),
        targets_(load_targets(capture_, context.optional_input("masks"), objects_, std::nullopt)),
        mesh_(read_mesh_ply(context.input("mesh") / "mesh" / "mesh.ply"), scene_.surfels.diffuse,
              voxel_of(context.input("mesh"))),
        // A scene trained on all photos is evaluated on them.
        judges_(capture_.heldout.empty() ? capture_.train : capture_.heldout) {
    leave_out_what_was_not_trained();
    targets_.forget(MaskClass::Object);  // the object loss is only for objects trained alone, by the optimize stage
    for (const TargetProblem& problem : targets_.warnings) context.warning(problem.code, problem.text);
  }

  void run() {
    step(0.01, "segments");
    views_ = views_of(capture_.train);
    report_["segments"] = segments_json(views_, capture_);
    make_folders(context_.output() / "refine");
    write_segments_picture(context_.output() / "refine/segments.png", views_, capture_, kMapLevel);
    tell_fallback();
    step(0.03, "thin or thick glass");
    decide_thickness();
    step(0.05, "free space");
    find_candidates();
    const QualityMeter meter(scene_, capture_, targets_, judges_);
    before_ = meter.of(scene_);
    for (size_t i = 0; i < candidates_.size(); ++i) {
      step(0.05 + 0.05 * double(i) / double(candidates_.size()), candidates_[i].name);
      candidates_[i].heldout = meter.of(candidates_[i].scene);
    }
    // An unchanged scene has converged: more steps never paid off (README.md).
    if (config_.fine_tune.iterations > 0 && (best() || config_.fine_tune.unchanged)) {
      Candidate tuned = fine_tuned(best());
      tell_motion(glass_motion(scene_.surfels.diffuse, tuned.scene.surfels.diffuse));
      tuned.heldout = meter.of(tuned.scene);
      candidates_.push_back(std::move(tuned));
    }
    choose();
  }

 private:
  // A scene trained inside object masks contains nothing else: refines and evaluates only inside them.
  void leave_out_what_was_not_trained() {
    const fs::path optimize = context_.input("optimize") / "optimize";
    if (!read_view_split(optimize / "views.json", capture_.view_set.views).object_alone) return;
    const fs::path widened = optimize / "trained";
    targets_.ignore_outside(fs::is_directory(widened) ? load_targets(capture_, widened, {}, std::nullopt) : Targets(targets_));
  }

  std::vector<GlassView> views_of(std::span<const uint32_t> photos) const {
    return glass_views({.capture = capture_,
                        .targets = targets_,
                        .scene = scene_,
                        .mesh = mesh_,
                        .segments = {.min_agreement = kLeastAgreement},
                        .level = kMapLevel},
                       photos);
  }

  void step(double fraction, std::string text) {
    throw_if_interrupted();
    context_.progress({.fraction = fraction, .text = std::move(text), .values = {}});
  }

  void tell_fallback() {
    const SegmentTotals t = segment_totals(views_);
    context_.metric("closed_share", t.share(SegmentKind::Closed));
    context_.metric("fallback_share", t.fallback_share());
    log_info("rays through glass: {:.0f} % have front and back, {:.0f} % an open pane, {:.0f} % keep the single segment",
             100 * t.share(SegmentKind::Closed), 100 * t.share(SegmentKind::Open), 100 * t.fallback_share());
    if (t.fallback_views > 0)
      context_.warning("MESH_NOT_TRUSTED",
                       fmt::format("in {} of {} photos the mesh disagrees with the rendered glass: they keep the single segment "
                                   "(refine/segments.png)",
                                   t.fallback_views, t.views));
  }

  // Determines the regions of solid glass and the scene that all candidates start from.
  void decide_thickness() {
    Json& report = report_["glass"] = {{"mode", kGlassWords[static_cast<size_t>(config_.glass)]}};
    start_ = scene_;
    if (bends(scene_)) return;  // trained with refraction: the solid shapes are known
    // Rays that leave solid glass need the room; thin glass with its own exterior layer does not show it.
    const bool room = scene_.image.transmission.glass == Glass::Thin || config_.exterior_set != ExteriorSet::Transmittance;
    if (config_.glass == GlassKind::Thin || !room) return;
    const float ior = static_cast<float>(config_.ior);
    std::vector<GlassView> heldout;
    if (!capture_.heldout.empty()) heldout = views_of(capture_.heldout);
    const std::vector<RegionThickness> regions = region_thickness({.capture = capture_,
                                                                   .scene = scene_,
                                                                   .seen = views_,
                                                                   .judges = heldout.empty() ? views_ : heldout,
                                                                   .mesh = mesh_,
                                                                   .ior = ior,
                                                                   .level = kMapLevel});
    log_thickness(regions);
    thick_.assign(mesh_.regions, 0);
    const std::vector<uint8_t> solid = regions_of_solid_glass(objects_, views_, mesh_);
    for (const RegionThickness& r : regions) {
      thick_[r.region] = config_.glass == GlassKind::Thick || solid[r.region] || r.thick();
      given_solid_ = given_solid_ || solid[r.region];
    }
    start_ = with_thick_glass(scene_, mesh_, thick_, ior);
    report["ior"] = rounded(config_.ior);
    report["regions"] = thickness_json(regions);
    context_.metric("thick_regions", double(std::ranges::count(thick_, 1)));
    if (config_.glass == GlassKind::Thick && !bends(start_))
      context_.warning("NO_CLOSED_GLASS",
                       "glass = thick changes nothing: the mesh has no closed glass that the photos agree with");
  }

  static bool bends(const TrainedScene& scene) { return scene.image.transmission.thick != nullptr; }
  // Solid glass set by the option or by the role of an object.
  bool forced() const { return (config_.glass == GlassKind::Thick || given_solid_) && bends(start_); }

  void find_candidates() {
    const SplatLayer& layer = scene_.surfels.transmittance;
    const std::vector<SurfelVotes> votes = surfel_votes(layer, views_, mesh_);
    std::vector<uint8_t> filled(votes.size()), within(votes.size());
    size_t empty = 0, beyond = 0;
    for (size_t i = 0; i < votes.size(); ++i) {
      const bool in_empty = stands_in_empty_space(votes[i]), is_beyond = stands_beyond(votes[i]);
      filled[i] = !in_empty;
      within[i] = !in_empty && !is_beyond;
      empty += in_empty;
      beyond += is_beyond;
    }
    report_["transmittance"] = {{"surfels", votes.size()}, {"in_empty_space", empty}, {"beyond_closed_glass", beyond}};
    const bool traced = scene_.image.transmission.glass == Glass::Traced;
    const auto add = [&](const char* name, const char* what, std::span<const uint8_t> keep, Glass glass) {
      Candidate c{.name = name, .what = what, .scene = start_};
      c.scene.surfels.transmittance = kept_surfels(layer, keep);
      c.scene.image.transmission.glass = glass;
      // Without surfels there would be no transmittance layer, and glass would not show the room.
      if (c.scene.surfels.transmittance.size() > 0) candidates_.push_back(std::move(c));
    };
    if (bends(start_)) {
      candidates_.push_back({.name = "thick_glass", .what = "rays bend in thick glass", .scene = start_});
      std::vector<uint8_t> clear = seen_through(layer, views_, thick_);
      for (size_t i = 0; i < clear.size(); ++i) clear[i] = filled[i] && !clear[i];
      Candidate c{.name = "thick_glass_clear", .what = "rays bend in thick glass with nothing in it", .scene = start_};
      c.scene.surfels.transmittance = kept_or_blank(layer, clear);
      candidates_.push_back(std::move(c));
    }
    if (empty > 0 && config_.exterior_set != ExteriorSet::Diffuse)
      add("free_space", "without surfels in empty space", filled, start_.image.transmission.glass);
    // Rays through glass see only the transmittance layer; after sorting, the room behind is in the diffuse layer.
    if ((beyond > 0 || traced) && config_.exterior_set != ExteriorSet::Transmittance)
      add("exterior_diffuse", "the room behind closed glass is the diffuse layer's", within, Glass::Thin);
  }

  // Fine-tunes the best scene so far.
  Candidate fine_tuned(const Candidate* from) {
    const FineTuneConfig& config = config_.fine_tune;
    const fs::path checkpoint = context_.scratch() / "checkpoint.bin";
    const TrainedScene& start = from ? from->scene : scene_;
    auto run = std::make_unique<FineTune>(config, capture_, targets_, start);
    if (!run->resume(checkpoint, [&](const std::string& why) { context_.warning("CHECKPOINT_IGNORED", why); }))
      run = std::make_unique<FineTune>(config, capture_, targets_, start);
    const auto fraction = [&] { return 0.1 + 0.85 * run->fraction(); };
    run->run({.checkpoint = checkpoint,
              .checkpoint_every = config.checkpoint_every,
              .after_step =
                  [&] {  // not through step(), which would stop without writing the checkpoint
                    context_.progress({.fraction = fraction(),
                                       .text = fmt::format("step {}/{}", run->step_index(), config.iterations),
                                       .values = {}});
                  },
              .after_checkpoint = [&] { context_.checkpoint(fraction()); }});
    Candidate tuned{.name = "fine_tuned",
                    .what = fmt::format("{} more steps", config.iterations) + (from ? ", " + from->what : std::string()),
                    .scene = {run->mean(), start.image}};
    for (const LayerKind kind : kAllLayers) {
      const std::span<const uint16_t> ids = start.surfels.layer(kind).object_ids();
      tuned.scene.surfels.layer(kind).set_object_ids({ids.begin(), ids.end()});
    }
    return tuned;
  }

  // Reports the displacement of glass: rays use the earlier mesh, which is valid only if the glass has not moved.
  void tell_motion(const GlassMotion& motion) {
    const double voxel = double(mesh_.voxel);
    report_["moved_voxels"] = {{"median", rounded(motion.median / voxel)}, {"p95", rounded(motion.p95 / voxel)}};
    if (motion.p95 > kMostMotionVoxels * voxel)
      context_.warning("MESH_OUTDATED",
                       fmt::format("fine-tuning moved glass by up to {:.1f} voxels away from the mesh: fewer steps "
                                   "(fine_tune.iterations) keep it there",
                                   motion.p95 / voxel));
  }

  bool is_better(const Candidate& c) const {
    if (forced()) return bends(c.scene);
    return c.heldout.glass >= before_.glass + kLeastGain && c.heldout.all >= before_.all - kMostLoss;
  }
  // nullptr: the unchanged scene.
  const Candidate* best() const {
    const Candidate* best = nullptr;
    for (const Candidate& c : candidates_)
      if (is_better(c) && (!best || c.heldout.glass > best->heldout.glass)) best = &c;
    return best;
  }

  void choose() {
    const Candidate* chosen = best();
    report_["candidates"] = Json::array();
    for (const Candidate& c : candidates_)
      report_["candidates"].push_back({{"name", c.name},
                                       {"what", c.what},
                                       {"transmittance_surfels", c.scene.surfels.transmittance.size()},
                                       {"psnr", json_of(c.heldout)}});
    const std::string judge = capture_.heldout.empty() ? "training photos" : "held-out photos";
    const Quality after = chosen ? chosen->heldout : before_;
    report_["judged_by"] = judge;
    report_["before"] = json_of(before_);
    report_["state"] = chosen ? "refined" : "kept";
    if (chosen) report_["chosen"] = chosen->name;
    report_["after"] = json_of(after);
    report_["glass"]["bent"] = chosen && bends(chosen->scene);
    if (bends(start_) && !bends(scene_) && !(chosen && bends(chosen->scene)))
      context_.warning(
          "THICK_GLASS",
          fmt::format("{} of the pieces of glass look solid, but pictures with bent rays gain nothing: they stay straight "
                      "(glass.regions in refine/report.json)",
                      std::ranges::count(thick_, 1)));
    write_file(context_.output() / "refine/report.json", report_.dump(2) + "\n");
    context_.metric("glass_psnr_before", before_.glass);
    context_.metric("glass_psnr", after.glass);
    if (!chosen) {
      context_.summary("kept the scene as it was: " + why_kept());
      return;
    }
    write_scene(chosen->scene);
    context_.summary(fmt::format("{}: glass {:.2f} -> {:.2f} dB in {}", chosen->what, before_.glass, after.glass, judge));
  }

  std::string why_kept() const {
    if (candidates_.empty()) return "nothing stands where it cannot be";
    double most = -INFINITY;
    for (const Candidate& c : candidates_) most = std::max(most, c.heldout.glass);
    return fmt::format("glass {:.2f} dB, changed {:.2f} dB", before_.glass, most);
  }

  void write_scene(const TrainedScene& scene) {
    const fs::path out = context_.output() / "refine";
    make_folders(out / "gaussians");
    for (const LayerKind kind : kAllLayers)
      if (kind == LayerKind::Diffuse || scene.surfels.layer(kind).size() > 0)
        write_layer(out / "gaussians" / fmt::format("{}.ply", name(kind)), scene.surfels.layer(kind));
    write_image_options(out / "model.json", scene.image);
  }

  const RefineConfig& config_;
  StageContext& context_;
  const TrainedScene scene_;
  const Capture capture_;
  const LabelledObjects objects_;
  Targets targets_;
  const GlassMesh mesh_;
  const std::vector<uint32_t> judges_;
  std::vector<GlassView> views_;
  TrainedScene start_;          // with solid glass, if any
  std::vector<uint8_t> thick_;  // [regions of the mesh]
  bool given_solid_ = false;    // an object of the table is solid glass
  std::vector<Candidate> candidates_;
  Quality before_;
  Json report_ = Json::object();
};

}  // namespace

void run_refine(const RefineConfig& config, StageContext& context) {
  set_thread_limit(context.threads());
  TrainedScene scene = read_trained_scene(context.input("optimize"));
  scene.surfels.opaque = {};  // the layers are evaluated without the opaque twin
  if (scene.surfels.transmittance.size() == 0) {
    const std::string why = "nothing to refine: no transmittance layer";
    write_file(context.output() / "refine/report.json", Json{{"state", "nothing"}, {"why", why}}.dump(2) + "\n");
    context.summary(why);
    return;
  }
  Refiner(config, context, std::move(scene)).run();
}

}  // namespace vitrine
