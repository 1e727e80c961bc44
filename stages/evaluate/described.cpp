#include <cmath>
#include <filesystem>

#include "core/render/raster/device.h"
#include "core/render/raster/renderer.h"
#include "stages/evaluate/evaluate.h"
#include "stages/training_cost.h"

namespace vitrine {

namespace {

constexpr const char* kViews = "Pictures from new places";
constexpr const char* kParts = "Parts of the picture";
constexpr const char* kTruth = "Against the truth";
constexpr double kFewestViews = 2;    // a single picture may be the best or the worst
constexpr double kFewestAligned = 5;  // cameras: three always fit the truth after an alignment

}  // namespace

void describe(Describer& d, EvaluateConfig& c) {
  d.choice("backend", c.backend, {"reference", "cpu"}, "Renderer: cpu, or reference (slow, double precision).");
  d.option("score_train_views", c.score_train_views, "Score the training views too, for reference.");
  d.option("write_pictures", c.write_pictures, "Write photo, render and error of every held-out view.");
  d.option("write_layers", c.write_layers, "Write the layers of the views on the contact sheet, where there is more than one.");
  d.option("samples", c.samples, "Rays that a rough pixel reflects; 0 = the way the scene was trained.").range(0, 4096);
  d.option("relit_samples", c.relit_samples, "Samples of a pixel under the truth's other lights; 0 = not measured.")
      .range(0, 4096);
  d.option("relit_views", c.relit_views, "Views to look at under each of the truth's other lights.").range(1, 10000);
  d.option("lpips", c.lpips,
           "safetensors file with VGG16 and the weights of LPIPS (core/learn/loss/README.md); empty = LPIPS is not measured.")
      .file();
  d.option("mesh_threshold_rel", c.mesh_threshold_rel, "Distance that counts as hit, relative to the truth's diagonal.")
      .range(1e-6, 1);
}

Stage evaluate_stage() {
  StageInfo info;
  info.name = "evaluate";
  info.version = 32;
  info.summary = "scores held-out views, and geometry where there is truth";
  info.inputs = {
      {.name = "sfm", .doc = "cameras, gains and undistorted photos"},
      {.name = "masks", .optional = true, .doc = "the object, to score apart, and what is to be ignored"},
      {.name = "objects", .optional = true, .doc = "glass, mirrors and coats to score apart, where the truth has none"},
      {.name = "optimize", .doc = "the trained surfels and the list of held-out views"},
      {.name = "refine", .optional = true, .doc = "better surfels behind glass"},
      {.name = "mesh", .optional = true, .doc = "the mesh, to compare with the truth's"},
      {.name = "decompose", .optional = true, .doc = "albedo and light, to compare with the truth's"},
      {.name = "truth", .artifact = false, .optional = true, .doc = "truth folder (README: layout)"}};
  info.doing = "measuring";
  info.cost = evaluate_cost;
  info.report = evaluate_report();
  info.device = kRasterDevice;
  return make_stage<EvaluateConfig>(std::move(info), run_evaluate, [] {
    return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
  });
}

StageCost evaluate_cost(const CostTerms& t) {
  const double every = t.number("optimize.holdout_every");
  const double held = every > 0 ? std::ceil(t.photos() / every) : 0, mpx = t.mpx(trained_side(t));
  double cpu_s = 2 + 5 * held * mpx + 0.2 * t.photos() * mpx, memory = 150 + 12 * t.photos() * mpx;
  if (t.is_given("input.truth")) {
    // Costs of sampling a truth mesh, of depths and normals of all views, and of relit pictures.
    cpu_s += 14;
    memory += 610;
    std::error_code ec;
    if (std::filesystem::is_directory(std::filesystem::path(t.text("input.truth")) / "relit", ec)) cpu_s += 12;
  }
  return stage_cost(cpu_s, 0.65, memory, 5 * held * mpx);
}

StageReport evaluate_report() {
  StageReport report{.file = "eval/metrics.json"};
  report.figures = {
      ReportFigure{kViews, "psnr", "New views, PSNR", "dB", 1, 27, 22,
                   "Photos that training never saw against their renders; mean over the held-out views.",
                   "Pictures from new places are soft or wrong in parts.", "heldout.psnr"}
          .measured_on("heldout.views", kFewestViews, "held-out views")
          .noted("{heldout.views:0} {heldout.views:view,views} held out of training"),
      ReportFigure{kViews, "ssim", "New views, SSIM", "", 3, 0.88, 0.75,
                   "The same pictures, structure instead of error; 1 is equal.",
                   "Fine structure is lost in pictures from new places.", "heldout.ssim"}
          .measured_on("heldout.views", kFewestViews, "held-out views"),
      ReportFigure{kViews, "flip", "New views, FLIP", "", 3, 0.13, 0.2,
                   "The same pictures, as a person sees the difference who flips between the two; 0 is equal.",
                   "Pictures from new places look different from photos.", "heldout.flip"}
          .measured_on("heldout.views", kFewestViews, "held-out views"),
      ReportFigure{kViews, "gap", "Training against new views", "dB", 1, 3, 6,
                   "By how much training photos come out better than held-out ones.",
                   "The scene knows its photos by heart: too few of them agree on what is seen from elsewhere.", "train.psnr"}
          .difference("heldout.psnr")
          .measured_on("heldout.views", kFewestViews, "held-out views")
          .noted("{train.psnr:1} dB where it trained, {heldout.psnr:1} dB where not"),
      ReportFigure{kViews, "weakest", "Weakest new view", "dB", 1, 3, 6, "How far the worst held-out view lies below the mean.",
                   "One side is much weaker than the others: more photos are missing there.", "heldout.psnr"}
          .folded("above_weakest_view")
          .measured_on("heldout.views", kFewestViews, "held-out views"),
      ReportFigure{
          kViews, "neutral_shift", "White stays white", "%", 0, 0.06, 0.15,
          "How far the channels of the render part where a held-out photo is bright, neutral and plain; the worst photo.",
          "A plain backdrop that is neutral in a photo has a colour in its render.", "neutral.shift"}
          .noted("{neutral.photo}"),
      {kViews, "confidence", "Confidence ranks the errors", "", 2, 0.5, 0.3,
       "Rank correlation of the confidence of pixels with the error of held-out photos; 1 is the same order.",
       "The confidence map does not show where errors are.", "confidence.rank_correlation"},
      ReportFigure{kParts, "region_transparent", "Glass", "dB", 1, 27, 22, "Held-out PSNR inside the masks of glass.",
                   "What stands behind the glass, or its reflections, is not yet understood.", "regions.transparent.psnr"}
          .measured_on("regions.transparent.views", kFewestViews, "held-out views"),
      ReportFigure{kParts, "region_reflective", "Mirrors and coats", "dB", 1, 27, 22,
                   "Held-out PSNR of what is glossy and not glass.", "Reflections are baked in or smeared.",
                   "regions.reflective.psnr"}
          .measured_on("regions.reflective.views", kFewestViews, "held-out views"),
      ReportFigure{kParts, "region_object", "The object", "dB", 1, 27, 22, "Held-out PSNR inside the object masks.",
                   "The object itself is soft from new places.", "regions.object.psnr"}
          .measured_on("regions.object.views", kFewestViews, "held-out views"),
      ReportFigure{kParts, "region_rest", "Everything else", "dB", 1, 27, 22,
                   "Held-out PSNR of what is neither glass, mirror nor coat.", "Even plain surfaces are soft from new places.",
                   "regions.rest.psnr"}
          .measured_on("regions.rest.views", kFewestViews, "held-out views"),
      ReportFigure{kTruth, "truth_rotation", "Camera directions", "deg", 2, 0.5, 2, "Against the truth after alignment, median.",
                   "Poses are off.", "truth.pose.rotation_deg"}
          .measured_on("truth.pose.views_in_alignment", kFewestAligned, "cameras to align"),
      ReportFigure{kTruth, "truth_centre", "Camera positions", "%", 2, 0.005, 0.02,
                   "Against the truth, relative to the camera ring, median.", "Poses are off.", "truth.pose.centre_rel"}
          .measured_on("truth.pose.views_in_alignment", kFewestAligned, "cameras to align"),
      {kTruth, "truth_normals", "Normals", "deg", 1, 10, 20, "Mean angle to the true surface, outside glass.",
       "Surfaces are bumpy or lie wrong.", "truth.normal_mae_deg"},
      {kTruth, "truth_depth", "Depth", "%", 2, 0.01, 0.03, "Relative to the truth, median.", "Surfaces lie in the wrong place.",
       "truth.depth_rel"},
      {kTruth, "truth_fscore", "Mesh, F-score", "", 3, 0.95, 0.8, "Share of the surface within 1 % of the diagonal, both ways.",
       "Parts of the surface are missing or stand where nothing is.", "truth.mesh.fscore"},
      ReportFigure{kTruth, "truth_transmitted", "Seen through glass", "dB", 1, 25, 20,
                   "What the rays found behind the glass against the truth.", "What stands behind the glass is not yet right.",
                   "truth.transmitted.psnr"}
          .measured_on("truth.transmitted.views", kFewestViews, "views with a truth"),
      ReportFigure{kTruth, "truth_albedo", "Albedo", "dB", 1, 25, 20,
                   "Against the true albedo, one factor per channel for the whole scene.", "Light remains in the albedo.",
                   "truth.albedo.psnr"}
          .measured_on("truth.albedo.views", kFewestViews, "views with a truth"),
      {kTruth, "truth_relit", "Under other lights", "dB", 1, 25, 20, "Pictures under new lights against the truth.",
       "Under a new light the scene will look off.", "truth.relit.psnr"}};
  report.facts = {{kViews, "{surfels:n} surfels", "surfels"},
                  {kViews, "pictures of {resolution.width:0} × {resolution.height:0}"}};
  return report;
}

}  // namespace vitrine
