#include "stages/sfm/sfm.h"

#include <algorithm>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/timer.h"
#include "core/intake/masks/mask_files.h"
#include "core/intake/photos/measures.h"
#include "core/intake/photos/photo_list.h"
#include "core/intake/poses/given_poses.h"
#include "core/intake/poses/named_poses.h"
#include "core/intake/poses/pose_check.h"
#include "core/intake/poses/pose_files.h"
#include "core/scene/camera/colmap_lens.h"
#include "core/scene/camera/holdout.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/ldr.h"
#include "stages/sfm/colmap_driver.h"
#include "stages/sfm/diagnosis.h"
#include "stages/sfm/focal_search.h"
#include "stages/sfm/gains/principal_point.h"
#include "stages/sfm/gps_frame.h"
#include "stages/sfm/object_poses.h"
#include "stages/sfm/outputs.h"
#include "stages/sfm/photo_gains.h"
#include "stages/sfm/rigs.h"
#include "stages/sfm/work_folder.h"
#include "stages/sfm/zoom_groups.h"

namespace vitrine {

namespace {

constexpr double kReconstructShare = 0.85;  // of the progress bar; the rest is undistortion
constexpr size_t kSmallestGiven = 3;        // given poses; two views do not make a reliable model
constexpr size_t kFewPoints = 100;          // below this there are too few points to initialise a scene
constexpr size_t kPointsWorthKeeping = 50;  // given models with fewer points are triangulated again

std::vector<SfmPhoto> sfm_photos(const fs::path& ingest, const std::vector<Photo>& photos) {
  std::vector<SfmPhoto> out;
  for (const Photo& p : photos)
    out.push_back({.name = p.name,
                   .picture = ingested_ldr_path(ingest, p),
                   .width = p.width,
                   .height = p.height,
                   .focal_px = p.focal_px,
                   .camera = p.camera,
                   .rig = p.rig});
  part_by_zoom(out, photos);
  return out;
}

// A given model with points does not need COLMAP.
Reconstruction complete_as_given(ColmapModel model, const std::vector<Photo>& photos) {
  Reconstruction r;
  for (const Photo& p : photos) r.photos.emplace_back().name = p.name;
  for (const ColmapImage& image : model.images)
    for (PhotoReport& p : r.photos)
      if (p.name == image.name) {
        p.registered = true;
        p.observations = static_cast<size_t>(std::count_if(image.points.begin(), image.points.end(),
                                                           [](const ColmapPoint2D& q) { return q.point3d_id != kNoPoint3D; }));
      }
  r.attempts.push_back({.what = "given model", .model_sizes = {model.images.size()}, .registered = model.images.size()});
  r.model = std::move(model);
  return r;
}

struct Solved {
  Reconstruction reconstruction;
  std::string colmap = "none";
  ObjectPasses passes = {};
  FocalSearch focals = {};
};

std::optional<FeatureMasks> feature_masks(const SfmConfig& config, StageContext& context, const std::vector<SfmPhoto>& photos) {
  const std::optional<fs::path> folder = context.optional_input("masks");
  if (!folder) {
    if (config.turntable == Turntable::Yes)
      throw Error(ErrorKind::Usage, "sfm.turntable=yes needs masks of the object",
                  {.hint = "--masks DIR (vitrine run), --input masks=DIR (vitrine-sfm)", .code = "SFM_TURNTABLE_WITHOUT_MASKS"});
    return std::nullopt;
  }
  FeatureMasks masks(*folder, config.masks, config.turntable, photos);
  if (masks.other_shape() > 0)
    context.warning("SFM_MASKS_OTHER_SHAPE",
                    fmt::format("{} masks have another shape than their photos as taken: features are not held to them",
                                masks.other_shape()));
  if (masks.empty()) return std::nullopt;
  return masks;
}

void tell(const Notes& notes, StageContext& context) {
  for (const Note& note : notes)
    if (note.code.empty())
      log_info("sfm: {}", note.text);
    else
      context.warning(note.code, note.text);
}

// Removes photos that are another version of one with a pose ("images_4/a.jpg").
ColmapModel given_model(const fs::path& poses, const SfmConfig& config, std::vector<Photo>& photos, StageContext& context,
                        PosePixels& pixels) {
  GivenPoses read = given_poses(poses, photos, config.pose_scale);
  if (context.optional_input("masks")) std::erase_if(read.notes, [](const Note& n) { return n.code == kMasksNamed; });
  tell(read.notes, context);
  pixels = std::move(read.pixels);
  for (auto i = read.other_versions.rbegin(); i != read.other_versions.rend(); ++i) photos.erase(photos.begin() + long(*i));
  ColmapModel given = std::move(read.model);
  log_info("sfm: {} of {} photos have given poses, {} points", given.images.size(), photos.size(), given.points.size());
  if (!given.points.empty() && given.points.size() < kPointsWorthKeeping)
    context.warning("POSES_FEW_POINTS", fmt::format("the {} points of the given model are too few to start from (fewer than {}): "
                                                    "points are triangulated from the photos",
                                                    given.points.size(), kPointsWorthKeeping));
  if (given.images.size() < kSmallestGiven || double(given.images.size()) < config.min_registered * double(photos.size()))
    throw Error(ErrorKind::Input, "too few photos have a given pose",
                {.where = poses.string(),
                 .why = fmt::format("{} of {} photos, need {:.0f} % and at least {}", given.images.size(), photos.size(),
                                    100 * config.min_registered, kSmallestGiven),
                 .hint = "give only the photos that have poses, or --set sfm.min_registered=0.3",
                 .code = "POSES_TOO_FEW"});
  return given;
}

void principal_points(ColmapModel& model, StageContext& context) {
  const Timer timer;
  const PrincipalPoints p = refine_principal_points(model);
  context.timing("principal_point", timer.seconds());
  if (!p.asked) return;
  context.metric("principal_point_error_before", p.error_before);
  context.metric("principal_point_error_after", p.error_after);
  const std::string text = fmt::format("{:.1f} % of the picture off its middle takes the error from {:.2f} to {:.2f} px",
                                       100 * p.furthest, p.error_before, p.error_after);
  if (p.moved)
    log_info("sfm: a principal point {}: it is used", text);
  else
    log_debug("sfm: a principal point {}: it stays in the middle", text);
}

Solved solved(const SfmConfig& config, StageContext& context, const fs::path& ingest, std::vector<Photo>& photos) {
  std::optional<ColmapModel> given;
  PosePixels pixels;
  const std::optional<fs::path> poses = context.optional_input("poses");
  if (poses) given = given_model(*poses, config, photos, context, pixels);
  Solved s;
  if (given && given->points.size() >= kPointsWorthKeeping) {
    std::map<std::string, const Photo*> photo_of;
    for (const Photo& p : photos) photo_of[p.name] = &p;
    CheckedPoses checked = checked_with_pictures(
        std::move(*given), pixels,
        [&](const ColmapImage& image) { return read_srgb8(ingested_ldr_path(ingest, *photo_of.at(image.name))); }, *poses);
    tell(pixels.notes, context);
    tell(checked.notes, context);
    s.reconstruction = complete_as_given(std::move(checked.model), photos);
  } else {
    const std::vector<SfmPhoto> list = sfm_photos(ingest, photos);
    const std::optional<FeatureMasks> masks = feature_masks(config, context, list);
    const WorkFolder work(context.scratch(), [&](const char* code, const std::string& text) { context.warning(code, text); });
    ReconstructDesc desc{.photos = list,
                         .work_folder = work.path(),
                         .threads = context.threads(),
                         .masks = masks ? &*masks : nullptr,
                         .progress =
                             [&](double fraction, const std::string& text) {
                               context.progress({.fraction = kReconstructShare * fraction, .text = text, .values = {}});
                             },
                         .timing = [&](const std::string& name, double seconds) { context.timing(name, seconds); }};
    Colmap colmap;
    log_debug("COLMAP {} at {}", colmap.version(), colmap.program().string());
    const PoseCheck check = [&](const ColmapModel& model, const std::vector<PhotoMatches>& matches) {
      CheckedPoses checked = checked_with_matches(model, pixels, matches, *poses);
      tell(pixels.notes, context);
      tell(checked.notes, context);
      return std::move(checked.model);
    };
    s = {given ? triangulate(colmap, config, desc, *given, check) : reconstruct(colmap, config, desc), colmap.version()};
    if (!given && !has_rigs(list) && !is_fisheye(colmap_camera_type(config.camera_model)->id))
      s.focals = cameras_by_focal(colmap, config, desc, s.reconstruction);
    report_focals(s.focals, context);
    const std::optional<MaskEffect>& effect = s.reconstruction.masks;
    if (!given && !(effect && effect->object_applied) && config.turntable != Turntable::No)
      s.passes = masks && masks->has(MaskClass::Object) ? poses_of_object(colmap, config, desc, *masks, s.reconstruction)
                                                        : passes_without_masks(desc, s.reconstruction);
    if (!given && has_rigs(list))
      one_pose_per_rig(colmap, config, desc, s.reconstruction, context);
    else if (!given && config.principal_point == PrincipalPoint::Auto)
      principal_points(s.reconstruction.model, context);
    if (s.passes.joined()) s.reconstruction.model = object_points(s.reconstruction.model, list, *masks);
  }
  if (given)
    for (PhotoReport& p : s.reconstruction.photos) p.pose_missing = !p.registered;
  return s;
}

// Measures blur and exposure when photos are missing.
void measure_photos(const fs::path& ingest, const std::vector<Photo>& photos, Reconstruction& r) {
  if (std::all_of(r.photos.begin(), r.photos.end(), [](const PhotoReport& p) { return p.registered; })) return;
  parallel_for(photos.size(), 1, [&](size_t i) {
    const PhotoMeasures m = measured(read_srgb8(ingested_ldr_path(ingest, photos[i])));
    r.photos[i].blur_px = m.blur_px;
    r.photos[i].brightness_ev = m.brightness_ev;
  });
}

// Compares EXIF's focal length with the calibrated one.
void compare_focal(const std::vector<Photo>& photos, const ColmapModel& model, StageContext& context) {
  constexpr double kFar = 1.33;
  size_t far = 0;
  double named = 0, solved = 0;
  for (const ColmapImage& image : model.images) {
    const auto photo = std::find_if(photos.begin(), photos.end(), [&](const Photo& p) { return p.name == image.name; });
    const ColmapCamera* camera = model.find_camera(image.camera_id);
    if (photo == photos.end() || !photo->focal_px || camera == nullptr || camera->params.empty()) continue;
    const double ratio = camera->params[0] / *photo->focal_px;
    if (ratio < kFar && ratio > 1 / kFar) continue;
    ++far;
    named = *photo->focal_px, solved = camera->params[0];
  }
  if (far > 0)
    context.warning("SFM_BAD_FOCAL",
                    fmt::format("EXIF names a focal length of {:.0f} pixels, {} photos agree on {:.0f}: cropped or edited "
                                "photos? The latter is used",
                                named, far, solved));
}

void report_gps(const std::optional<GpsFit>& gps, StageContext& context) {
  if (!gps) return;
  log_info("sfm: {}", gps_text(*gps));
  if (gps->used()) context.metric("metres_per_unit", gps->metres_per_unit);
}

void run(const SfmConfig& config, StageContext& context) {
  const fs::path ingest = context.input("ingest"), output = context.output();
  std::vector<Photo> photos = read_photo_list(ingest);
  Solved s = solved(config, context, ingest, photos);
  measure_photos(ingest, photos, s.reconstruction);
  const Reconstruction& r = s.reconstruction;
  const Diagnosis diagnosis = diagnosed(r, config);
  if (!diagnosis.code.empty()) {
    // The output folder is removed on failure; the scratch folder keeps the evidence.
    const fs::path evidence = context.scratch() / "report.json";
    SfmReportDesc report;
    report.reconstruction = &r;
    report.colmap = s.colmap;
    report.code = diagnosis.code;
    report.passes = &s.passes;
    write_sfm_report(evidence, report);
    write_match_matrix(context.scratch() / "evidence" / "matches.png", r);
    throw_diagnosis(diagnosis, evidence);
  }
  report_passes(s.passes, r.model, config.up, context);
  for (const PhotoReport& p : r.photos)
    if (!p.registered && !p.other_pass) context.warning("SFM_PHOTO_LEFT_OUT", fmt::format("{}: {}", p.name, reason_left_out(p)));
  if (s.passes.poses != PosesOf::LargestPass && !r.attempts.empty() && r.attempts.back().model_sizes.size() > 1)
    context.warning("SFM_SPLIT_MODEL", fmt::format("the photos fall into {} models; the largest has {}",
                                                   r.attempts.back().model_sizes.size(), r.model.images.size()));

  if (!context.optional_input("poses")) compare_focal(photos, r.model, context);
  FilterCounts counts;
  const ColmapModel kept = filtered(r.model, counts);
  const CutPhotos cut = cut_photos(kept, photos, ingest);
  const std::vector<Undistortion>& undistortions = cut.undistortions;
  report_cut_photos(cut, context);
  const size_t pictures = cut.model.images.size();
  Timer timer;
  write_pictures({.ingest = ingest, .output = output, .photos = &cut, .progress = [&](size_t done) {
                    context.progress({.fraction = kReconstructShare + (1 - kReconstructShare) * double(done) / double(pictures),
                                      .text = fmt::format("undistorted {}/{}", done, pictures),
                                      .values = {}});
                  }});
  context.timing("undistort", timer.seconds());
  ColmapModel model = undistorted(cut.model, undistortions);
  // Views of a cut photo are not level, and have one place. With several passes, use one: each has another side of the object up.
  const ColmapModel& whole = cut.cut > 0 ? kept : model;
  const ColmapModel still = s.passes.joined() ? restricted(whole, s.passes.passes[0]) : whole;
  Orientation orientation = scene_up(still, config.up);
  std::optional<GpsFit> gps =
      fitted_gps(gps_sightings(still, photos), {.orientation = orientation,
                                                .up_chosen = config.up != UpMethod::Auto,
                                                .given_poses = context.optional_input("poses").has_value()});
  SceneInfo scene = framed_scene(model, orientation, gps);
  report_gps(gps, context);
  transform_world(model, scene.scene_from_colmap);
  for (const ColmapPoint3D& p : model.points) scene.bounds.extend(p.position);
  if (model.points.size() < kFewPoints)
    context.warning("SFM_FEW_POINTS", fmt::format("{} scene points were found: hardly anything shows that the poses are right",
                                                  model.points.size()));
  if (model.points.empty())
    for (const ColmapImage& image : model.images) scene.bounds.extend(inverse(image.cam_from_world()).translation);

  const fs::path sparse = output / "sparse" / "0";
  make_folders(sparse);
  make_folders(output / "sfm");
  write_colmap_model(sparse, model, ColmapFormat::Binary);
  write_colmap_model(sparse, model, ColmapFormat::Text);
  write_scene_info(output / "scene.json", scene);
  timer.restart();
  if (!r.pairs.empty()) write_match_matrix(output / "sfm" / "evidence" / "matches.png", r);
  write_gains(output / "sfm" / "gains.json", photo_gains(model, cut.photos, output, context));
  context.timing("gains", timer.seconds());
  write_transforms_json(output / "transforms.json", load_view_set(output).views, "images");
  if (scene.geo) add_geo_origin(output / "transforms.json", *scene.geo);
  Rigs rigs;
  for (const Photo& p : cut.photos)
    if (p.rig && std::ranges::any_of(model.images, [&](const ColmapImage& image) { return image.name == p.name; }))
      rigs[p.name] = p.rig->panorama;
  if (!rigs.empty()) write_rigs(output, rigs);
  write_lenses(output / "sfm" / "lenses.json", undistortions, model, r, photos);
  write_sfm_report(output / "sfm" / "report.json", {.reconstruction = &r,
                                                    .colmap = s.colmap,
                                                    .final_model = &model,
                                                    .undistortions = undistortions,
                                                    .orientation = orientation,
                                                    .points = counts,
                                                    .passes = &s.passes,
                                                    .gps = gps ? &*gps : nullptr,
                                                    .focals = s.focals});
  double error = 0, observations = 0;
  for (const ColmapPoint3D& p : model.points) {
    error += p.error_px * double(p.track.size());
    observations += double(p.track.size());
  }
  context.metric("photos", double(photos.size()));
  context.metric("registered", double(kept.images.size()));
  context.metric("points", double(model.points.size()));
  if (observations > 0) context.metric("reprojection_px", error / observations);
  // Without points there is no reprojection error to report.
  context.summary(fmt::format("registered {}/{}{}, {} points{}{}", kept.images.size(), photos.size(),
                              cut.cut > 0 ? fmt::format(" (cut into {} views)", pictures) : "", model.points.size(),
                              observations > 0 ? fmt::format(", {:.2f} px", error / observations) : "",
                              s.passes.joined() ? ", " + passes_text(s.passes.passes) : ""));
}

}  // namespace

Stage sfm_stage() {
  StageInfo info{.name = "sfm",
                 .version = 13,
                 .summary = "camera poses, undistorted photos and sparse points in a normalised frame",
                 .inputs = {{.name = "ingest", .doc = "artifact of ingest"},
                            {.name = "poses",
                             .artifact = false,
                             .optional = true,
                             .doc = "given poses: COLMAP model, transforms.json, Metashape, OpenSfM, OpenMVG, 3x4 matrices",
                             .meant = meant_poses},
                            {.name = "masks",
                             .artifact = false,
                             .optional = true,
                             .doc = "masks of the photos, a folder per class: object, transparent, specular, ignore",
                             .skips = {".yaml", ".yml"},
                             .also = files_of_mask_list}},
                 .doing = "finding the camera poses",
                 .cost = sfm_cost,
                 .report = sfm_report()};
  return make_stage<SfmConfig>(std::move(info), run, [] {
    return std::map<std::string, std::string>{{"colmap", colmap_fingerprint()}};
  });
}

}  // namespace vitrine
