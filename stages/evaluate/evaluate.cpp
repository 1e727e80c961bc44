// A single class, because every view is rendered once and all figures use that picture. Each figure has its own file (regions,
// view_error, albedo_error, relit_error, mesh_error ...).
#include "stages/evaluate/evaluate.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/quantile.h"
#include "core/learn/loss/lpips.h"
#include "core/render/picture/confidence.h"
#include "core/render/picture/surfel_colors.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/metrics.h"
#include "core/scene/mesh/mesh_io.h"
#include "stages/evaluate/albedo_error.h"
#include "stages/evaluate/regions.h"
#include "stages/evaluate/relit_error.h"
#include "stages/evaluate/report.h"
#include "stages/evaluate/truth.h"
#include "stages/evaluate/view_error.h"

namespace vitrine {
namespace {

constexpr int kMeshViewSide = 640;                       // sufficient for visibility
constexpr size_t kSheetRows = 4;                         // views on the contact sheet
constexpr double kRenderShare = 0.7, kRelitShare = 0.2;  // of the progress bar

// `count` of [0, n), evenly spread.
std::vector<size_t> spread(size_t n, size_t count) {
  std::vector<size_t> picked;
  const size_t m = std::min(n, count);
  for (size_t i = 0; i < m; ++i) picked.push_back(i * n / m);
  return picked;
}

class Evaluator {
 public:
  Evaluator(const EvaluateConfig& config, StageContext& context)
      : config_(config),
        context_(context),
        sfm_(context.input("sfm")),
        views_(load_view_set(sfm_, context.input("optimize")).views),
        painter_(read_trained_scene(context.input("optimize"), context.optional_input("refine")),
                 {.backend = config.backend, .layers = true, .samples = config.samples, .medium = true}),
        layered_(painter_.surfels().reflection.size() + painter_.surfels().transmittance.size() > 0) {
    if (!config.lpips.empty()) lpips_.emplace(config.lpips);
    result_.split = read_view_split(context.input("optimize") / "optimize" / "views.json", views_);
    result_.registered_views = views_.size();
    for (LayerKind kind : kAllLayers) result_.surfels += painter_.surfels().layer(kind).size();
    result_.mesh_threshold_rel = config.mesh_threshold_rel;
    result_.min_region_pixels = config.min_region_pixels;
    make_folders(context.output() / "eval");
  }

  void run() {
    if (const auto folder = context_.optional_input("truth")) open_truth(*folder);
    masks_ = context_.optional_input("masks");
    objects_ = LabelledObjects::all(context_.optional_input("objects"));
    known_ = LabelledObjects::known(context_.optional_input("objects"));
    regions_.emplace(truth_ ? &*truth_ : nullptr, masks_, objects_);
    result_.regions_from = regions_->from();
    measure_confidence();
    score_views();
    result_.confidence = confidence_against_error(confidence_samples_);
    if (truth_) finish_truth();
    for (const auto& [id, iou] : agreement_.iou())
      if (const auto known = result_.objects.find(id); known != result_.objects.end()) known->second.iou = iou;
    result_.surfel_objects = agreement_.surfel_accuracy();
    write_file(context_.output() / "eval" / "metrics.json", metrics_json(result_));
    write_file(context_.output() / "eval" / "per_view.csv", per_view_csv(result_));
    sheet_.write(context_.output() / "eval" / "contact_sheet.jpg");
    report();
  }

 private:
  void open_truth(const fs::path& folder) {
    truth_.emplace(folder, views_);
    result_.truth.emplace();
    if (!truth_->has_cameras()) {
      not_measured("truth.pose", "the truth has no transforms.json; normals, depth and mesh need its cameras as well");
      return;
    }
    std::vector<CameraPair> pairs;
    for (size_t i = 0; i < views_.size(); ++i)
      if (truth_->camera(i)) {
        pairs.push_back({views_[i].cam_from_world, truth_->camera(i)->cam_from_world});
        paired_.push_back(i);
      }
    if (pairs.size() < 2) {
      not_measured("truth.pose", fmt::format("transforms.json and this run have {} photos in common", pairs.size()));
      return;
    }
    result_.truth->alignment = align_cameras(pairs, truth_->transforms_path().string());
    truth_->align(result_.truth->alignment->truth_from_ours, views_);
    open_albedo();
    result_.truth->poses = pose_errors(pairs, result_.truth->alignment->truth_from_ours);
  }

  void open_albedo() {
    if (!truth_->has_maps("albedo")) return;
    const auto folder = context_.optional_input("decompose");
    if (!folder) return not_measured("truth.albedo", "there is no decompose artifact");
    albedo_.emplace(painter_.surfels(), painter_.image(), read_decomposed_materials(*folder, painter_.surfels()));
  }

  void score_albedo(size_t index, const ViewPicture& render, const RegionMasks& masks) {
    const auto truth = truth_->albedo(index, render.intrinsics);
    if (!truth) return;
    View view = views_[index];
    view.intrinsics = render.intrinsics;
    albedo_error_.add({render.intrinsics, albedo_->picture(view), *render.layer("diffuse"), mask_of(masks, "object"),
                       mask_of(masks, "transparent")},
                      *truth);
  }

  const Similarity* truth_from_ours() const {
    return result_.truth && result_.truth->alignment ? &result_.truth->alignment->truth_from_ours : nullptr;
  }

  void measure_confidence() {
    const auto photo = [&](const View& v) { return photo_srgb(sfm_, v, v.intrinsics); };
    confidence_ = surfel_confidence(painter_, at_trained_size(views_, result_.split.train, result_.split), photo);
  }

  // Confidence of a held-out view against its error, and the map as a picture.
  void score_confidence(const View& seen, const ViewPicture& render, const ImageF& photo, const std::optional<ImageF>& judged) {
    ImageF counts = render.zdepth;
    if (judged) keep_within(*judged, counts);
    const ImageF map = confidence_map(painter_.surfels().diffuse, confidence_, painter_.image().diffuse.near_z, seen);
    add_confidence_samples(map, absolute_error(render.srgb, photo), counts, confidence_samples_);
    if (config_.write_pictures) write_confidence(context_.output() / "eval", seen, map);
  }

  // Renders each view once; photo figures for the split, surface figures for every view with truth maps.
  void score_views() {
    std::vector<std::pair<size_t, bool>> order;
    for (size_t v : result_.split.heldout) order.emplace_back(v, true);
    const bool heldout_exists = !result_.split.heldout.empty();
    if (config_.score_train_views || !heldout_exists)
      for (size_t v : result_.split.train) order.emplace_back(v, false);
    if (!heldout_exists) not_measured("heldout", "no view was held out from training");
    const size_t sheet_candidates = heldout_exists ? result_.split.heldout.size() : order.size();
    const std::vector<size_t> sheet_views = spread(sheet_candidates, kSheetRows);
    for (size_t i = 0; i < order.size(); ++i) {
      throw_if_interrupted();
      const bool on_sheet = std::find(sheet_views.begin(), sheet_views.end(), i) != sheet_views.end();
      score_view(order[i].first, order[i].second, on_sheet);
      context_.progress({.fraction = kRenderShare * double(i + 1) / double(order.size()),
                         .text = fmt::format("view {}/{}", i + 1, order.size()),
                         .values = {}});
    }
  }

  void score_view(size_t index, bool heldout, bool on_sheet) {
    const View& view = views_[index];
    View seen = view;
    seen.intrinsics = view.intrinsics.limited_to(result_.split.max_side);
    ViewPicture render = painter_.picture(seen);
    ImageF photo = photo_srgb(sfm_, view, render.intrinsics);
    // Untrained pixels are not scored, and black in the pictures.
    std::optional<ImageF> judged;
    if (const auto within = trained_within()) judged = stage_mask(*within, view, MaskClass::Object, render.intrinsics);
    if (judged) keep_within(*judged, photo), keep_within(*judged, render.srgb);
    const ImageF* within = judged ? &*judged : nullptr;
    ViewScore score;
    score.name = view.name, score.heldout = heldout;
    score.psnr = psnr(render.srgb, photo, within), score.ssim = ssim(render.srgb, photo, within);
    score.flip = flip(render.srgb, photo, within);
    if (lpips_) score.lpips = lpips_->distance(render.srgb, photo);
    if (result_.views.empty()) result_.resolution = render.intrinsics;
    RegionMasks masks = regions_->of(index, view, render.intrinsics);
    if (judged)
      for (auto& [region, pixels] : masks) keep_within(*judged, pixels);
    score.regions = region_errors(masks, render.srgb, photo, config_.min_region_pixels, heldout);
    if (heldout) score_objects(index, render, photo, judged, score);
    if (heldout) score.neutral_shift = shift_of_neutral(view, render, photo, judged, masks);
    if (truth_from_ours()) score_surface(index, render, masks, score);
    if (truth_) score_transmitted(index, render, masks);
    if (truth_ && heldout) score_clear(index, render);
    if (albedo_) score_albedo(index, render, masks);
    if (heldout) score_confidence(seen, render, photo, judged);
    if (heldout && config_.write_pictures) {
      write_pictures(context_.output() / "eval", view, render.srgb, photo);
      if (!render.clear.empty()) write_clear(context_.output() / "eval", view, render.clear);
    }
    if (on_sheet) show(view, render, photo, score);
    result_.views.push_back(std::move(score));
  }

  void score_objects(size_t index, const ViewPicture& render, const ImageF& photo, const std::optional<ImageF>& judged,
                     ViewScore& score) {
    Image16 labels = known_.labels(views_[index], render.intrinsics);
    if (labels.empty()) return;
    for (const Object& object : known_.objects().objects) {
      ImageF shown(labels.width(), labels.height(), 1);
      std::ranges::transform(labels.data(), shown.data().begin(), [&](uint16_t id) { return id == object.id ? 1.f : 0.f; });
      if (judged) keep_within(*judged, shown);
      const auto error = region_error(shown, render.srgb, photo, config_.min_region_pixels, true);
      if (!error) continue;
      score.objects[object.id] = *error;
      auto& scored = result_.objects[object.id];
      scored.name = object.name, scored.role = name(object.role), scored.trust = name(object.trust);
    }
    View seen = views_[index];
    seen.intrinsics = render.intrinsics;
    agreement_.add({seen, std::move(labels)});
  }

  // Masks inside which the scene was trained; nullopt if it was trained everywhere.
  std::optional<fs::path> trained_within() const {
    if (!result_.split.object_alone) return std::nullopt;
    const fs::path widened = context_.input("optimize") / "optimize/trained";
    return fs::is_directory(widened) ? widened : masks_;
  }

  // Colour cast of trained opaque pixels, outside glass and mirrors.
  std::optional<double> shift_of_neutral(const View& view, const ViewPicture& render, const ImageF& photo,
                                         const std::optional<ImageF>& judged, const RegionMasks& masks) const {
    ImageF counts = render.zdepth;
    const auto only = [&](const ImageF& mask, bool inside) {
      for (size_t i = 0; i < counts.data().size(); ++i)
        if ((mask.data()[i] > 0) != inside) counts.data()[i] = 0;
    };
    if (judged) only(*judged, true);
    if (const ImageF* rest = mask_of(masks, "rest")) only(*rest, true);
    if (masks_)
      if (const auto ignored = stage_mask(*masks_, view, MaskClass::Ignore, render.intrinsics)) only(*ignored, false);
    return neutral_shift(render.srgb, photo, counts, config_.min_region_pixels);
  }

  void show(const View& view, const ViewPicture& render, const ImageF& photo, const ViewScore& score) {
    sheet_.start_row(fmt::format("{}  {:.2f} DB  SSIM {:.3f}{}", view.stem(), score.psnr, score.ssim,
                                 score.heldout ? "" : "  (TRAINING VIEW)"));
    add_view(render, photo, layered_ ? std::optional(view.gain) : std::nullopt, sheet_);
    if (layered_ && config_.write_layers) write_layers(context_.output() / "eval", view, render);
  }

  void score_surface(size_t index, const ViewPicture& render, const RegionMasks& masks, ViewScore& score) {
    if (const auto it = std::find(paired_.begin(), paired_.end(), index); it != paired_.end())
      score.pose = result_.truth->poses[size_t(it - paired_.begin())];
    SurfaceTruth truth;
    truth.normal = truth_->normal(index, render.intrinsics).value_or(ImageF());
    truth.zdepth = truth_->zdepth(index, render.intrinsics).value_or(ImageF());
    ImageF opaque(render.intrinsics.width, render.intrinsics.height, 1, 1.f);
    if (const ImageF* glass = mask_of(masks, "transparent"))
      for (size_t i = 0; i < opaque.data().size(); ++i) opaque.data()[i] -= glass->data()[i];
    SurfaceError here;
    add_surface_error(render, truth, *truth_from_ours(), &opaque, here);
    if (!here.normal_deg.empty()) score.normal_mae_deg = mean(here.normal_deg);
    if (!here.zdepth_rel.empty()) score.zdepth_rel = median(here.zdepth_rel);
    surface_.normal_deg.insert(surface_.normal_deg.end(), here.normal_deg.begin(), here.normal_deg.end());
    surface_.zdepth_rel.insert(surface_.zdepth_rel.end(), here.zdepth_rel.begin(), here.zdepth_rel.end());
    for (const auto& [region, region_mask] : masks) {
      ImageF counts = region_mask;
      if (region == "object")  // object pixels behind glass belong to the glass
        for (size_t i = 0; i < counts.data().size(); ++i) counts.data()[i] *= opaque.data()[i];
      add_surface_error(render, truth, *truth_from_ours(), &counts, region_surface_[region]);
    }
  }

  void score_transmitted(size_t index, const ViewPicture& render, const RegionMasks& masks) {
    const ImageF* glass = mask_of(masks, "transparent");
    const ImageF *transmitted = render.layer("transmitted"), *picture = render.layer(render.clear.empty() ? "radiance" : "clear");
    if (glass == nullptr || transmitted == nullptr) return;
    const auto truth = truth_->transmitted(index, render.intrinsics);
    if (!truth) return;
    ImageF radiance = *transmitted;  // the rendered picture where no ray passed through glass
    for (size_t i = 0; i < radiance.pixel_count(); ++i)
      if (float* const pixel = &radiance.data()[3 * i]; pixel[0] + pixel[1] + pixel[2] == 0)
        std::copy_n(&picture->data()[3 * i], 3, pixel);
    const auto score =
        radiance_psnr({render.intrinsics, radiance, views_[index].gain, *glass}, *truth, config_.min_region_pixels);
    if (score) transmitted_.push_back(*score);
  }

  // The picture without water or haze; that of a scene without a medium is the clear one.
  void score_clear(size_t index, const ViewPicture& render) {
    const auto truth = truth_->clear(index, render.intrinsics);
    if (!truth) return;
    const ImageF everywhere(render.intrinsics.width, render.intrinsics.height, 1, 1.f);
    const ImageF& clear = render.clear.empty() ? render.linear : render.clear;
    const auto score =
        radiance_psnr({render.intrinsics, clear, views_[index].gain, everywhere}, *truth, config_.min_region_pixels);
    if (score) clear_.push_back(*score);
  }

  void finish_truth() {
    TruthScores& t = *result_.truth;
    if (!surface_.normal_deg.empty()) {
      t.normal_mae_deg = mean(surface_.normal_deg);
      t.normal_median_deg = median(surface_.normal_deg);
    } else if (t.alignment) {
      not_measured("truth.normal_mae_deg", "no truth normal covers an opaque pixel of ours");
    }
    for (const auto& [region, errors] : region_surface_) {
      SurfaceScore& s = t.regions[region];
      if (!errors.normal_deg.empty()) s.normal_mae_deg = mean(errors.normal_deg), s.normal_median_deg = median(errors.normal_deg);
      if (!errors.zdepth_rel.empty()) s.zdepth_rel = median(errors.zdepth_rel);
    }
    if (const auto it = t.regions.find("object"); it != t.regions.end()) t.object_normal_mae_deg = it->second.normal_mae_deg;
    if (!transmitted_.empty()) t.transmitted_psnr = mean(transmitted_);
    t.transmitted_views = transmitted_.size();
    if (!clear_.empty()) t.clear_psnr = mean(clear_);
    t.clear_views = clear_.size();
    if (albedo_) {
      t.albedo = albedo_error_.scores();
      if (!t.albedo->psnr) not_measured("truth.albedo.psnr", "no truth albedo covers an object pixel of ours outside the glass");
    }
    if (painter_.surfels().transmittance.size() > 0 && transmitted_.empty())
      not_measured("truth.transmitted", "no scored view has a truth/transmitted picture and a transparent mask");
    if (!surface_.zdepth_rel.empty())
      t.zdepth_rel = median(surface_.zdepth_rel);
    else if (t.alignment)
      not_measured("truth.depth_rel", "no truth depth covers an opaque pixel of ours");
    if (t.alignment) score_relit();
    const auto truth_mesh = truth_->mesh_path();
    const auto mesh = context_.optional_input("mesh");
    if (!truth_mesh || !mesh) return not_measured("truth.mesh", mesh ? "the truth has no mesh.ply" : "there is no mesh artifact");
    if (t.alignment) score_mesh(*truth_mesh, *mesh);
  }

  void score_relit() {
    TruthScores& t = *result_.truth;
    if (config_.relit_samples == 0 || relit_environments(*truth_).empty()) return;
    const auto decompose = context_.optional_input("decompose");
    const auto mesh = context_.optional_input("mesh");
    if (!decompose || !mesh)
      return not_measured("truth.relit", fmt::format("there is no {} artifact", decompose ? "mesh" : "decompose"));
    RelitErrorDesc desc{.truth = *truth_,
                        .views = views_,
                        .truth_from_ours = t.alignment->truth_from_ours,
                        .albedo_scale = {},
                        .samples = config_.relit_samples,
                        .max_views = config_.relit_views,
                        .pictures = config_.write_pictures ? context_.output() / "eval" / "relit" : fs::path()};
    if (t.albedo && t.albedo->psnr) desc.albedo_scale = t.albedo->scale;
    t.relit_scale_mode = desc.albedo_scale ? "albedo times truth.albedo.scale, one factor per channel for the whole scene"
                                           : "pictures times one factor per channel and environment: median of truth / ours over "
                                             "the object (the truth has no albedo)";
    t.relit = relit_scores(
        read_relit_scene({.optimize = context_.input("optimize"),
                          .refine = context_.optional_input("refine"),
                          .mesh = *mesh,
                          .decompose = *decompose}),
        [&](size_t view, const Intrinsics& k) { return regions_->of(view, views_[view], k); }, desc,
        [&](double f) {
          throw_if_interrupted();
          context_.progress({.fraction = kRenderShare + kRelitShare * f, .text = "other lights", .values = {}});
        });
    if (!mean_relit_psnr(t))
      not_measured("truth.relit.psnr", "no truth picture under another light shows an object pixel of ours outside the glass");
  }

  void score_mesh(const fs::path& truth_mesh_path, const fs::path& mesh) {
    const TriMesh truth = read_truth_mesh(truth_mesh_path);
    const fs::path with_glass = truth_->folder() / "mesh.ply";
    const TriMesh first_surface = fs::exists(with_glass) ? read_truth_mesh(with_glass) : truth;
    const TriMesh ours = transformed(read_mesh_ply(mesh / "mesh" / "mesh.ply"), *truth_from_ours());
    const std::vector<size_t> picked = spread(paired_.size(), size_t(config_.mesh_views));
    const auto view = [&](size_t i) {
      throw_if_interrupted();
      context_.progress(
          {.fraction = kRenderShare + kRelitShare + (1 - kRenderShare - kRelitShare) * double(i) / double(picked.size()),
           .text = fmt::format("mesh visibility {}/{}", i + 1, picked.size()),
           .values = {}});
      const size_t index = paired_[picked[i]];
      const View& camera = *truth_->camera(index);
      const Intrinsics k = camera.intrinsics.limited_to(kMeshViewSide);
      return MeshView{k, camera.cam_from_world, truth_->zdepth(index, k, LookupFrame::Truths).value_or(ImageF()),
                      truth_->mask(index, MaskClass::Transparent, k, LookupFrame::Truths).value_or(ImageF())};
    };
    MeshErrorDesc desc;
    desc.samples = size_t(config_.mesh_samples);
    desc.threshold_rel = config_.mesh_threshold_rel;
    result_.truth->mesh = mesh_error(ours, truth, first_surface, picked.size(), view, desc);
    if (result_.truth->mesh->our_samples == 0)
      not_measured("truth.mesh.accuracy_rel", "no sample of our mesh lies where two views see the truth mesh");
    if (result_.truth->mesh->truth_samples == 0)
      not_measured("truth.mesh.completeness_rel", "no sample of the truth mesh is the first surface in two views");
  }

  void not_measured(const std::string& key, const std::string& reason) {
    result_.not_measured[key] = reason;
    context_.warning("NOT_MEASURED", key + ": " + reason);
  }

  void report() {
    const auto metric = [&](const char* name, std::optional<double> value) {
      if (value) context_.metric(name, *value);
    };
    const auto heldout = mean_score(result_, true);
    metric("heldout.psnr", heldout ? std::optional(heldout->psnr) : std::nullopt);
    metric("heldout.ssim", heldout ? std::optional(heldout->ssim) : std::nullopt);
    metric("heldout.flip", heldout ? std::optional(heldout->flip) : std::nullopt);
    if (const ViewScore* v = strongest_neutral_shift(result_)) metric("neutral.shift", v->neutral_shift);
    if (const auto& t = result_.truth) {
      metric("truth.normal_mae_deg", t->normal_mae_deg);
      metric("truth.mesh.fscore", t->mesh ? std::optional(t->mesh->fscore) : std::nullopt);
      metric("truth.clear.psnr", t->clear_psnr);
      metric("truth.albedo.psnr", t->albedo ? t->albedo->psnr : std::nullopt);
      metric("truth.relit.psnr", mean_relit_psnr(*t));
    }
    context_.summary(summary_line(result_));
  }

  const EvaluateConfig& config_;
  StageContext& context_;
  fs::path sfm_;
  std::vector<View> views_;
  std::vector<float> confidence_;  // of the diffuse surfels
  ConfidenceSamples confidence_samples_;
  ScenePainter painter_;
  bool layered_;  // true if there are layers other than the diffuse one
  std::optional<Lpips> lpips_;
  std::optional<fs::path> masks_;
  LabelledObjects objects_, known_;  // known_: without guessed objects; source of the surfels' ids
  ObjectAgreement agreement_{painter_.surfels().diffuse, painter_.image().diffuse.near_z, known_.objects()};
  std::optional<Truth> truth_;
  std::optional<RegionSource> regions_;
  std::vector<size_t> paired_;  // views with a truth camera
  SurfaceError surface_;        // outside the glass
  std::map<std::string, SurfaceError> region_surface_;
  std::vector<double> transmitted_, clear_;
  std::optional<AlbedoPainter> albedo_;
  AlbedoError albedo_error_;
  ContactSheet sheet_{5};
  Evaluation result_;
};

}  // namespace

void run_evaluate(const EvaluateConfig& config, StageContext& context) { Evaluator(config, context).run(); }

}  // namespace vitrine
