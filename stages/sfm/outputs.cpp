#include "stages/sfm/outputs.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/json_file.h"
#include "core/foundation/config/text.h"
#include "core/intake/poses/colmap_repair.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "stages/sfm/diagnosis.h"

namespace vitrine {

namespace {

constexpr int kJpegQuality = 97;  // of undistorted photos with JPEG names

bool is_png(const std::string& name) { return lower_extension(name) == ".png"; }

// `taken`: as it was ingested, `photo` or what it is cut from.
void write_one(const PicturesDesc& desc, const Photo& photo, const Photo& taken, const Undistortion& u) {
  const fs::path linear_to = desc.output / "linear" / (photo.stem + ".exr"), ldr_to = desc.output / "images" / photo.name;
  const fs::path linear_from = ingested_linear_path(desc.ingest, taken), ldr_from = ingested_ldr_path(desc.ingest, taken);
  make_folders(linear_to.parent_path());
  make_folders(ldr_to.parent_path());
  if (u.identity) {
    // No resampling: the ingested bytes are the undistorted picture.
    link_or_copy(linear_from, linear_to);
    if (is_png(photo.name)) {
      link_or_copy(ldr_from, ldr_to);
      return;
    }
    write_ldr(ldr_to, srgb8_from_linear(read_exr_rgb(linear_from)), kJpegQuality);
    return;
  }
  const ImageF linear = read_exr_rgb(linear_from);
  if (linear.width() != int(u.source.width) || linear.height() != int(u.source.height))
    throw Error(ErrorKind::Input, "a photo's size changed since it was ingested",
                {.where = linear_from.string(),
                 .why = fmt::format("{} x {} pixels, its camera has {} x {}", linear.width(), linear.height(), u.source.width,
                                    u.source.height),
                 .hint = "run ingest again",
                 .code = "SFM_PHOTO_SIZE"});
  const ImageF straight = undistorted(linear, u);
  write_exr_rgb(linear_to, straight);
  write_ldr(ldr_to, srgb8_from_linear(straight), kJpegQuality);
}

nlohmann::json camera_json(const ColmapCamera& c) {
  const ColmapCameraType* type = colmap_camera_type(c.model_id);
  return {{"id", c.id},
          {"model", type ? std::string(type->name) : std::to_string(c.model_id)},
          {"width", c.width},
          {"height", c.height},
          {"params", c.params}};
}

nlohmann::json masks_json(const MaskEffect& effect) {
  nlohmann::json j{{"features", effect.before}, {"features_used", effect.after}};
  for (MaskClass kind : kMaskClasses)
    if (effect.photos[size_t(kind)] > 0)
      j["classes"][std::string(name(kind))] = {{"photos_with_mask", effect.photos[size_t(kind)]},
                                               {"features_removed", effect.removed[size_t(kind)]}};
  j["turntable"] = {{"option", kTurntableWords[size_t(effect.turntable)]}, {"object_mask_applied", effect.object_applied}};
  if (const auto& e = effect.evidence; e)
    j["turntable"]["evidence"] = {{"why", e->why},
                                  {"pairs", e->pairs},
                                  {"outside_told", e->outside_told},
                                  {"outside_still", e->outside_still},
                                  {"inside_told", e->inside_told},
                                  {"inside_moves", e->inside_moves}};
  return j;
}

nlohmann::json passes_json(const ObjectPasses& passes) {
  if (passes.passes.empty()) return {{"count", 1}};
  std::vector<size_t> sizes;
  size_t all = 0;
  for (const std::vector<std::string>& photos : passes.passes) sizes.push_back(photos.size()), all += photos.size();
  nlohmann::json j{{"count", sizes.size()},
                   {"sizes", sizes},
                   {"text", passes_text(passes.passes)},
                   {"contradicting_pairs", passes.contradicting},
                   {"furthest_match_deg", passes.furthest_match}};
  if (passes.poses != PosesOf::Object) j["share_of_largest"] = double(sizes[0]) / double(all);
  for (const std::vector<std::string>& photos : passes.passes) j["photos"].push_back(photos);
  return j;
}

nlohmann::json gps_json(const GpsFit& fit) {
  nlohmann::json j{{"photos", fit.photos}, {"used", fit.used()}, {"text", gps_text(fit)}};
  if (fit.used()) {
    j["agreeing"] = fit.agreeing;
    j["rms_m"] = fit.rms_m;
    j["scale_precision"] = fit.precision;
    j["metres_per_unit"] = fit.metres_per_unit;
  }
  return j;
}

nlohmann::json focals_json(const FocalSearch& focals) {
  nlohmann::json j{{"found", kFocalVerdictWords[size_t(focals.verdict)]},
                   {"error_before_px", focals.error_before},
                   {"error_own_focals_px", focals.error_own}};
  if (focals.verdict != FocalVerdict::Several) return j;
  j["error_after_px"] = focals.error_after;
  j["text"] = focals.text();
  for (const FocalSearch::Group& g : focals.groups) j["cameras"].push_back({{"focal_px", g.focal_px}, {"photos", g.photos}});
  return j;
}

}  // namespace

ColmapModel undistorted(const ColmapModel& model, const std::vector<Undistortion>& per_camera) {
  VITRINE_CHECK(per_camera.size() == model.cameras.size(), "{} undistortions for {} cameras", per_camera.size(),
                model.cameras.size());
  ColmapModel out = model;
  for (size_t c = 0; c < out.cameras.size(); ++c) out.cameras[c] = colmap_pinhole(model.cameras[c].id, per_camera[c].target);
  for (ColmapImage& image : out.images) {
    const auto camera =
        std::find_if(model.cameras.begin(), model.cameras.end(), [&](const ColmapCamera& c) { return c.id == image.camera_id; });
    const Undistortion& u = per_camera[static_cast<size_t>(camera - model.cameras.begin())];
    if (u.rotation) {
      const Rigid turned = Rigid{*u.rotation, {}} * image.cam_from_world();
      image.rotation = quaternion(turned.rotation), image.translation = turned.translation;
    }
    for (ColmapPoint2D& p : image.points) {
      if (p.point3d_id == kNoPoint3D) continue;
      const std::optional<Vec2d> moved = undistorted({p.x, p.y}, u);
      if (moved) {
        p.x = moved->x;
        p.y = moved->y;
      } else {
        p.point3d_id = kNoPoint3D;
      }
    }
  }
  return compacted(std::move(out), [](const ColmapPoint3D& p) { return p.track.size() >= 2; });
}

void write_pictures(const PicturesDesc& desc) {
  const CutPhotos& cut = *desc.photos;
  std::map<std::string, const Photo*> photo_of;
  for (const Photo& p : cut.photos) photo_of[p.name] = &p;
  std::map<uint32_t, const Undistortion*> undistortion_of;
  for (size_t c = 0; c < cut.undistortions.size(); ++c) undistortion_of[cut.model.cameras[c].id] = &cut.undistortions[c];
  size_t done = 0;
  std::mutex reporting;
  parallel_for(cut.model.images.size(), 1, [&](size_t i) {
    throw_if_interrupted();
    const ColmapImage& image = cut.model.images[i];
    const Photo& photo = *photo_of.at(image.name);
    write_one(desc, photo, cut.photo_of(photo), *undistortion_of.at(image.camera_id));
    const std::lock_guard lock(reporting);
    ++done;
    if (desc.progress) desc.progress(done);
  });
}

void write_match_matrix(const fs::path& path, const Reconstruction& r) {
  const int n = int(r.photos.size());
  constexpr int kSide = 720;
  const int cell = std::clamp(kSide / std::max(n, 1), 1, 40);
  Image8 image(n * cell, n * cell, 3, uint8_t{245});
  const auto fill = [&](size_t row, size_t column, std::array<int, 3> colour) {
    for (int y = 0; y < cell - (cell > 3); ++y)
      for (int x = 0; x < cell - (cell > 3); ++x)
        for (int c = 0; c < 3; ++c) image.at(int(column) * cell + x, int(row) * cell + y, c) = uint8_t(colour[size_t(c)]);
  };
  constexpr double kFull = 1000;  // matches of the darkest cell
  for (const PairReport& p : r.pairs) {
    const double strength = std::min(std::log1p(double(p.verified)) / std::log1p(kFull), 1.0);
    const std::array<int, 3> colour{int(215 - 200 * strength), int(225 - 135 * strength), int(245 - 75 * strength)};
    fill(p.a, p.b, colour);
    fill(p.b, p.a, colour);
  }
  for (size_t i = 0; i < r.photos.size(); ++i)
    fill(i, i, r.photos[i].registered ? std::array<int, 3>{40, 150, 60} : std::array<int, 3>{210, 40, 40});
  make_folders(path.parent_path());
  write_ldr(path, image);
}

void write_sfm_report(const fs::path& path, const SfmReportDesc& desc) {
  const Reconstruction& r = *desc.reconstruction;
  nlohmann::json j;
  j["colmap"] = desc.colmap;
  j["pairs"] = {{"compared", r.pairs_compared}, {"matched", r.pairs_matched}, {"verified", r.pairs_verified}};
  j["connected_groups"] = r.groups;
  j["rotation_share"] = r.rotation_share;
  j["uncalibrated_share"] = r.uncalibrated_share;
  for (const Attempt& a : r.attempts)
    j["attempts"].push_back({{"what", a.what}, {"registered", a.registered}, {"model_sizes", a.model_sizes}});
  if (r.masks) j["masks"] = masks_json(*r.masks);
  if (r.rigs)
    j["rigs"] = {{"count", r.rigs->rigs},
                 {"views", r.rigs->views},
                 {"views_without_own_pose", r.rigs->completed},
                 {"error_before_px", r.rigs->error_before},
                 {"error_after_px", r.rigs->error_after}};
  if (desc.focals.verdict != FocalVerdict::One) j["focal_lengths"] = focals_json(desc.focals);
  if (desc.passes != nullptr) j["passes"] = passes_json(*desc.passes);
  size_t registered = 0;
  j["photos"] = nlohmann::json::array();
  for (const PhotoReport& p : r.photos) {
    registered += p.registered;
    nlohmann::json row{{"name", p.name},
                       {"features", p.features},
                       {"matches", p.matches},
                       {"verified_matches", p.verified},
                       {"neighbours", p.neighbours},
                       {"registered", p.registered},
                       {"observations", p.observations}};
    if (r.masks) row["masked_features"] = p.masked;
    row["group"] = p.group;
    if (p.blur_px) row["blur_px"] = *p.blur_px;
    if (p.brightness_ev) row["brightness_ev"] = *p.brightness_ev;
    if (!p.registered) {
      row["reason"] = reason_left_out(p);
      row["cause"] = cause_left_out(p, r);
    }
    j["photos"].push_back(std::move(row));
  }
  j["registered"] = registered;
  j["photo_count"] = r.photos.size();
  if (!desc.code.empty()) j["failed"] = desc.code;
  if (desc.final_model != nullptr) {
    const ColmapModel& m = *desc.final_model;
    double error = 0;
    size_t observations = 0;
    for (const ColmapPoint3D& p : m.points) {
      error += p.error_px * double(p.track.size());
      observations += p.track.size();
    }
    j["points"] = {{"triangulated", desc.points.before},
                   {"large_error", desc.points.large_error},
                   {"few_views", desc.points.few_views},
                   {"behind_a_camera", desc.points.behind},
                   {"small_angle", desc.points.small_angle},
                   {"lonely", desc.points.lonely},
                   {"kept", m.points.size()},
                   {"observations", observations}};
    if (observations > 0) j["mean_reprojection_error_px"] = error / double(observations);  // else there is none
    const bool by_gps = desc.gps != nullptr && desc.gps->used();
    if (desc.gps != nullptr) j["gps"] = gps_json(*desc.gps);
    j["up"] = {{"method", by_gps ? "gps" : kUpMethodWords[size_t(desc.orientation.method)]},
               {"in_colmap_frame", {desc.orientation.up.x, desc.orientation.up.y, desc.orientation.up.z}}};
  }
  write_file(path, j.dump(2) + "\n");
}

void write_lenses(const fs::path& path, const std::vector<Undistortion>& undistortions, const ColmapModel& model,
                  const Reconstruction& r, std::span<const Photo> photos) {
  nlohmann::json j{{"cameras", nlohmann::json::array()}, {"without_camera", nlohmann::json::array()}};
  for (size_t c = 0; c < undistortions.size(); ++c) {
    const Undistortion& u = undistortions[c];
    nlohmann::json& row = j["cameras"].emplace_back(nlohmann::json{
        {"photographed", camera_json(u.source)}, {"undistorted", camera_json(model.cameras[c])}, {"resampled", !u.identity}});
    if (!u.rotation) continue;
    const Quatd q = quaternion(*u.rotation);
    row["view_from_photo"] = {q.w, q.x, q.y, q.z};
    row["circle_px"] = u.circle_px;
  }
  for (const PhotoReport& p : r.photos)
    if (!p.registered) j["without_camera"].push_back(p.name);
  if (2 * std::ranges::count_if(photos, &Photo::flash) > std::ptrdiff_t(photos.size())) j["camera_flash"] = true;
  if (2 * std::ranges::count_if(photos, &Photo::cut_out) > std::ptrdiff_t(photos.size())) j["cut_out"] = true;
  write_json_file(path, j);
}

}  // namespace vitrine
