// Results of one evaluation, and their files: eval/metrics.json (nested; missing figures are listed with a reason in
// `not_measured`) and eval/per_view.csv.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/render/picture/view_picture.h"
#include "core/scene/camera/view.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/contact_sheet.h"
#include "core/scene/image/image.h"
#include "stages/evaluate/albedo_error.h"
#include "stages/evaluate/alignment.h"
#include "stages/evaluate/mesh_error.h"
#include "stages/evaluate/regions.h"
#include "stages/evaluate/relit_error.h"
#include "stages/evaluate/view_error.h"

namespace vitrine {

struct ViewScore {
  std::string name;
  bool heldout = false;
  double psnr = 0, ssim = 0, flip = 0;
  std::optional<double> lpips;  // with weights (core/learn/loss/lpips.h)
  RegionErrors regions;
  std::map<uint16_t, RegionError> objects;  // by id in the table of objects
  std::optional<PoseError> pose;
  std::optional<double> normal_mae_deg, zdepth_rel;
  std::optional<double> neutral_shift;  // nullopt: too few bright, neutral and textureless pixels
};

struct SurfaceScore {
  std::optional<double> normal_mae_deg, normal_median_deg, zdepth_rel;
};

struct TruthScores {
  std::optional<Alignment> alignment;
  std::vector<PoseError> poses;
  std::optional<double> normal_mae_deg, normal_median_deg, object_normal_mae_deg, zdepth_rel;
  std::map<std::string, SurfaceScore> regions;  // over all scored views
  std::optional<double> transmitted_psnr;       // mean over the views with this ground truth
  size_t transmitted_views = 0;
  std::optional<double> clear_psnr;  // mean over the held-out views with this ground truth
  size_t clear_views = 0;
  std::optional<AlbedoScores> albedo;
  std::vector<RelitScore> relit;
  std::string relit_scale_mode;
  std::optional<MeshError> mesh;
};

struct Evaluation {
  ViewSplit split;
  size_t registered_views = 0, surfels = 0;
  Intrinsics resolution;         // of the first scored view, as rendered
  std::vector<ViewScore> views;  // held-out first, then training views
  std::optional<TruthScores> truth;
  double mesh_threshold_rel = 0;
  int min_region_pixels = 0;
  struct ObjectScore {
    std::string name, role, trust;  // as in objects.json
    std::optional<double> iou;      // (ObjectAgreement)
  };
  std::map<uint16_t, ObjectScore> objects;          // by id: objects of the table visible in some held-out view
  std::optional<double> surfel_objects;             // share of surfels with the correct id
  std::optional<ConfidenceScore> confidence;        // of held-out views
  std::string regions_from;                         // "truth", "objects", or empty: none
  std::map<std::string, std::string> not_measured;  // key of metrics.json -> reason
};

struct MeanScore {
  double psnr = 0, ssim = 0, flip = 0;
  std::optional<double> lpips;
  size_t views = 0;
};
// Mean over the environments; nullopt without any.
std::optional<double> mean_relit_psnr(const TruthScores& t);
std::optional<MeanScore> mean_score(const Evaluation& e, bool heldout);
// Held-out view with the strongest colour cast in neutral pixels; nullptr: no view has enough of them.
const ViewScore* strongest_neutral_shift(const Evaluation& e);
std::string metrics_json(const Evaluation& e);
std::string per_view_csv(const Evaluation& e);
// Summary for the terminal.
std::string summary_line(const Evaluation& e);

// Output pictures of the stage: the photo at render size, error, normal, depth and layer pictures.

// Mean absolute sRGB difference over the channels: black 0, through violet and orange to white = 0.25 and more.
Image8 error_picture(const ImageF& srgb, const ImageF& photo_srgb);
Image8 normal_picture(const ImageF& normal);  // rgb = (n + 1) / 2, black = none
// Inverse depth, near is bright (there may be a sky); 2nd to 98th percentile; black = none.
Image8 depth_picture(const ImageF& zdepth);

// Adds photo, render, error, normals and depth to the sheet. With `gain` (of the view) also one cell per layer of `picture`:
// radiance times the gain, encoded; weights as grey, 1 = white.
void add_view(const ViewPicture& picture, const ImageF& photo_srgb, const std::optional<Vec3d>& gain, ContactSheet& sheet);
// eval/<stem>_clear.png: radiance without the medium of the photos.
void write_clear(const std::filesystem::path& eval_folder, const View& view, const ImageF& clear);
// eval/<stem>_{gt,pred,err}.png
void write_pictures(const std::filesystem::path& eval_folder, const View& view, const ImageF& srgb, const ImageF& photo_srgb);
// eval/<stem>_conf.png, the confidence map [h,w,1]: viridis, violet 0, yellow 1; black = no surface
void write_confidence(const std::filesystem::path& eval_folder, const View& view, const ImageF& confidence);
// eval/layers/<layer>/<stem>.exr
void write_layers(const std::filesystem::path& eval_folder, const View& view, const ViewPicture& picture);

}  // namespace vitrine
