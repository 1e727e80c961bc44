#include "stages/evaluate/report.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/json.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/image/metrics.h"

namespace vitrine {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kRegions[] = {"transparent", "specular", "reflective", "mirror", "coated", "object", "rest"};

Json definitions(const Evaluation& e) {
  Json d;
  d["heldout.psnr"] =
      "PSNR in dB of sRGB values clipped to [0,1], squared error over pixels and channels of a view, then the mean over the "
      "views held "
      "out from training; the render times the view's gain (from the SfM tracks) against the undistorted photo at training "
      "resolution";
  if (e.split.object_alone) d["within"] = "the object's masks, and what stands still with it: the scene was trained there alone";
  d["heldout.ssim"] = "SSIM (11x11 Gaussian window, sigma 1.5, per channel), same pictures, mean over held-out views";
  d["heldout.flip"] = fmt::format(
      "LDR-FLIP (Andersson et al. 2020): 0 = no visible difference, 1 = the largest; {:.2f} pixels per degree of vision (a "
      "display "
      "0.7 m wide of 3840 pixels, seen from 0.7 m), same pictures, mean over pixels of a view, then over held-out views",
      kFlipPixelsPerDegree);
  d["train"] = "the same figures over the training views: for reference only, the scene was fitted to them";
  d["regions.*.psnr"] = fmt::format(
      "PSNR of the squared error pooled over the region's pixels of a held-out view, mean over views with at least {} such "
      "pixels; "
      "reflective = specular and not transparent, rest = neither transparent nor specular; where the truth has masks of clear "
      "coats, coated = these without the transparent, mirror = reflective and not coated; masks from {}",
      e.min_region_pixels, e.regions_from == "objects" ? "the objects stage" : "the truth");
  d["regions.*.pooled_psnr"] = "the same, squared error pooled over the pixels of all these views";
  d["regions.*.correlation"] =
      "how far render and photo vary alike within windows of 7x7 pixels that lie in the region: sum of the covariances of their "
      "means over the channels / square root of the product of the sums of the variances; 1: the same structure, 0: nothing in "
      "common";
  if (!e.objects.empty()) {
    d["objects.*"] = "the figures of regions.*, over the pixels with the object's label";
    d["objects.*.iou"] =
        "pixels of all held-out views in which the surfels that carry the object's id have the largest blended weight and the "
        "label is the object's, over the pixels where one of the two holds";
    d["surfel_objects"] =
        "share of the surfels that held-out views show which carry the id of the label that outweighs the others there";
  }
  if (e.confidence)
    d["confidence.rank_correlation"] =
        "Spearman correlation of the confidence of a pixel with minus its mean absolute sRGB error, over the opaque pixels of "
        "held-out views; the confidence is measured in training photos alone: 0.05 / (0.05 + their mean error where the surfel "
        "shows)";
  d["neutral.shift"] = fmt::format(
      "the largest ratio between two channels of (render / photo), less 1: median over the pixels of a held-out view that are "
      "bright, neutral and without texture in the photo and opaque in the render, in linear light; the largest of the views with "
      "at least {} such pixels",
      e.min_region_pixels);
  if (!e.truth) return d;
  d["truth.pose"] =
      "after the similarity that best aligns the camera centres: angle between the orientations (median over views), distance of "
      "the "
      "centres relative to the ring radius of the truth's cameras (median)";
  d["truth.normal_mae_deg"] =
      "mean angle between our blended, normalised normal and the truth's, over all views with a truth map, pixels with our alpha "
      ">= 1/2, "
      "a truth normal, and outside the transparent mask";
  d["truth.regions.*"] =
      "the same figures over the pixels of one region (in `transparent`: of the glass itself, the first surface of the truth)";
  d["truth.transmitted.psnr"] =
      "PSNR of the transmitted radiance, of the picture's own where no ray went through, times the view's gain, against "
      "truth/transmitted, both encoded to sRGB and clipped, over the transparent mask at the coarser of the two resolutions, "
      "mean "
      "over the views with such a truth";
  d["truth.clear.psnr"] =
      "PSNR of the picture without the water or haze of the photos, times the view's gain, against truth/clear, both encoded to "
      "sRGB and clipped, at the coarser of the two resolutions, mean over the held-out views with such a truth";
  d["truth.albedo.psnr"] =
      "PSNR of the albedo, times one factor per channel for the whole scene (median of truth / ours over the object's pixels), "
      "clipped to [0,1], to the power 1/2.2, squared error pooled over the pixels of the object outside the glass of a view, "
      "mean "
      "over all scored views; pixels where a channel of the truth is 0 (metal) do not count. through_glass: the object behind "
      "glass, everywhere: all pixels with a truth, undecomposed: the diffuse radiance taken for an albedo, over the same pixels, "
      "with factors of its own";
  d["truth.relit.psnr"] =
      "PSNR of the scene under another environment against truth/relit, both encoded to sRGB and clipped, squared error pooled "
      "over the pixels of the object outside the glass of a view, mean over views, then over environments; scale_mode says what "
      "was multiplied before. with_glass: the object and what glass shows of it, everywhere: all pixels, ssim: all pixels, "
      "regions: the pixels of one region";
  d["truth.depth_rel"] = "median of |z - z_truth| / z_truth over the same pixels";
  d["truth.mesh"] = fmt::format(
      "lengths relative to the diagonal of the truth mesh's bounding box. accuracy = mean distance of our samples to the truth "
      "mesh, "
      "completeness = mean distance of the truth's samples to our mesh, chamfer = their mean; fscore = harmonic mean of the "
      "shares within "
      "{}. A truth sample counts when it is the first surface in at least 2 views, outside the transparent mask. Our sample "
      "counts when "
      "at least 2 views that see it, and more than half of all views that see it, show an opaque surface of the truth mesh at "
      "its pixel",
      e.mesh_threshold_rel);
  return d;
}

Json truth_json(const TruthScores& t) {
  Json j = Json::object();
  if (t.alignment) {
    std::vector<double> rotation, centre;
    for (const PoseError& p : t.poses) rotation.push_back(p.rotation_deg), centre.push_back(p.centre_rel);
    j["pose"] = {{"rotation_deg", median(rotation)},
                 {"rotation_max_deg", *std::max_element(rotation.begin(), rotation.end())},
                 {"centre_rel", median(centre)},
                 {"centre_max_rel", *std::max_element(centre.begin(), centre.end())},
                 {"views", t.poses.size()},
                 {"views_in_alignment", t.alignment->used},
                 {"truth_units_per_scene_unit", t.alignment->truth_from_ours.scale}};
  }
  if (t.normal_mae_deg) j["normal_mae_deg"] = *t.normal_mae_deg;
  if (t.normal_median_deg) j["normal_median_deg"] = *t.normal_median_deg;
  if (t.object_normal_mae_deg) j["normal_object_mae_deg"] = *t.object_normal_mae_deg;
  if (t.zdepth_rel) j["depth_rel"] = *t.zdepth_rel;
  for (const auto& [region, s] : t.regions) {
    Json score = Json::object();
    if (s.normal_mae_deg) score["normal_mae_deg"] = *s.normal_mae_deg, score["normal_median_deg"] = *s.normal_median_deg;
    if (s.zdepth_rel) score["depth_rel"] = *s.zdepth_rel;
    if (!score.empty()) j["regions"][region] = score;
  }
  if (t.transmitted_psnr) j["transmitted"] = {{"psnr", *t.transmitted_psnr}, {"views", t.transmitted_views}};
  if (t.clear_psnr) j["clear"] = {{"psnr", *t.clear_psnr}, {"views", t.clear_views}};
  if (t.albedo) {
    Json& albedo = j["albedo"] = Json::object();
    if (t.albedo->psnr) albedo["psnr"] = *t.albedo->psnr;
    if (t.albedo->through_glass) albedo["through_glass_psnr"] = *t.albedo->through_glass;
    if (t.albedo->everywhere) albedo["everywhere_psnr"] = *t.albedo->everywhere;
    if (t.albedo->undecomposed) albedo["undecomposed_psnr"] = *t.albedo->undecomposed;
    albedo["scale_mode"] = "one factor per channel for the whole scene: median of truth / ours over the object";
    albedo["scale"] = {t.albedo->scale.x, t.albedo->scale.y, t.albedo->scale.z};
    albedo["views"] = t.albedo->views;
  }
  if (!t.relit.empty()) {
    Json& relit = j["relit"] = Json::object();
    if (const auto mean_psnr = mean_relit_psnr(t)) relit["psnr"] = *mean_psnr;
    relit["scale_mode"] = t.relit_scale_mode;
    std::map<std::string, std::vector<double>> regions;
    for (const RelitScore& r : t.relit)
      for (const auto& [region, psnr] : r.region_psnr) regions[region].push_back(psnr);
    for (const auto& [region, psnr] : regions) relit["regions"][region]["psnr"] = mean(psnr);
    for (const RelitScore& r : t.relit) {
      Json& score = relit["environments"][r.environment] = Json::object();
      if (r.psnr) score["psnr"] = *r.psnr;
      if (r.with_glass_psnr) score["with_glass_psnr"] = *r.with_glass_psnr;
      if (r.everywhere_psnr) score["everywhere_psnr"] = *r.everywhere_psnr;
      if (r.ssim) score["ssim"] = *r.ssim;
      for (const auto& [region, psnr] : r.region_psnr) score["regions"][region]["psnr"] = psnr;
      score["picture_scale"] = {r.scale.x, r.scale.y, r.scale.z};
      score["views"] = r.views;
    }
  }
  if (t.mesh) {
    const MeshError& m = *t.mesh;
    Json& mesh = j["mesh"] = Json::object();
    if (m.our_samples > 0) mesh["accuracy_rel"] = m.accuracy_rel, mesh["accuracy_median_rel"] = m.accuracy_median_rel;
    if (m.truth_samples > 0 && std::isfinite(m.completeness_rel))
      mesh["completeness_rel"] = m.completeness_rel, mesh["completeness_median_rel"] = m.completeness_median_rel;
    if (mesh.contains("accuracy_rel") && mesh.contains("completeness_rel")) mesh["chamfer_rel"] = m.chamfer_rel;
    mesh["precision"] = m.precision;
    mesh["recall"] = m.recall;
    mesh["fscore"] = m.fscore;
    mesh["samples"] = {{"ours", m.our_samples}, {"truth", m.truth_samples}};
    mesh["diagonal"] = m.diagonal;
  }
  return j;
}

template <class Key>
const RegionError* found(const std::map<Key, RegionError>& errors, const Key& key) {
  const auto it = errors.find(key);
  return it == errors.end() ? nullptr : &it->second;
}

// Mean scores of held-out views for one region; empty: no view contains it.
template <class ErrorOf>
Json heldout_score(const Evaluation& e, const ErrorOf& error_of) {
  std::vector<double> psnr;
  RegionError pooled;
  for (const ViewScore& v : e.views)
    if (const RegionError* error = v.heldout ? error_of(v) : nullptr) {
      psnr.push_back(error->squared.psnr());
      pooled.squared += error->squared, pooled.correlation += error->correlation;
    }
  if (psnr.empty()) return Json::object();
  Json score = {{"psnr", mean(psnr)}, {"pooled_psnr", pooled.squared.psnr()}};
  if (const auto correlation = pooled.correlation.value()) score["correlation"] = *correlation;
  score["views"] = psnr.size();
  return score;
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::optional<double> mean_relit_psnr(const TruthScores& t) {
  std::vector<double> psnr;
  for (const RelitScore& r : t.relit)
    if (r.psnr) psnr.push_back(*r.psnr);
  return psnr.empty() ? std::nullopt : std::optional(mean(psnr));
}

std::optional<MeanScore> mean_score(const Evaluation& e, bool heldout) {
  std::vector<double> psnr, ssim, flip, lpips;
  for (const ViewScore& v : e.views)
    if (v.heldout == heldout) {
      psnr.push_back(v.psnr), ssim.push_back(v.ssim), flip.push_back(v.flip);
      if (v.lpips) lpips.push_back(*v.lpips);
    }
  if (psnr.empty()) return std::nullopt;
  return MeanScore{mean(psnr), mean(ssim), mean(flip), lpips.empty() ? std::nullopt : std::optional(mean(lpips)), psnr.size()};
}

const ViewScore* strongest_neutral_shift(const Evaluation& e) {
  const ViewScore* strongest = nullptr;
  for (const ViewScore& v : e.views)
    if (v.heldout && v.neutral_shift && (strongest == nullptr || *v.neutral_shift > *strongest->neutral_shift)) strongest = &v;
  return strongest;
}

std::string metrics_json(const Evaluation& e) {
  Json j;
  j["format"] = "vitrine-metrics 1";
  for (const auto& [key, heldout] : {std::pair{"heldout", true}, {"train", false}})
    if (const auto m = mean_score(e, heldout)) {
      j[key] = {{"psnr", m->psnr}, {"ssim", m->ssim}, {"flip", m->flip}, {"views", m->views}};
      if (m->lpips) j[key]["lpips"] = *m->lpips;
    }
  Json regions = Json::object();
  for (std::string_view region : kRegions)
    if (Json score = heldout_score(e, [&](const ViewScore& v) { return found(v.regions, std::string(region)); }); !score.empty())
      regions[std::string(region)] = std::move(score);
  if (!regions.empty()) {
    regions["masks"] = e.regions_from;
    j["regions"] = regions;
  }
  for (const auto& [id, object] : e.objects) {
    const Json score = heldout_score(e, [&, key = id](const ViewScore& v) { return found(v.objects, key); });
    if (score.empty()) continue;
    Json entry = {{"id", id}, {"name", object.name}, {"role", object.role}, {"trust", object.trust}};
    entry.update(score);
    if (object.iou) entry["iou"] = *object.iou;
    j["objects"].push_back(std::move(entry));
  }
  if (e.surfel_objects) j["surfel_objects"] = *e.surfel_objects;
  if (const auto& c = e.confidence)
    j["confidence"] = {{"rank_correlation", c->rank_correlation}, {"mean", c->mean}, {"pixels", c->pixels}};
  if (const ViewScore* v = strongest_neutral_shift(e)) {
    const auto measured = std::count_if(e.views.begin(), e.views.end(),
                                        [](const ViewScore& s) { return s.heldout && s.neutral_shift.has_value(); });
    j["neutral"] = {{"shift", *v->neutral_shift}, {"photo", v->name}, {"views", measured}};
  }
  if (e.truth) j["truth"] = truth_json(*e.truth);
  j["resolution"] = {{"width", e.resolution.width}, {"height", e.resolution.height}, {"max_side", e.split.max_side}};
  j["views"] = {{"registered", e.registered_views},
                {"train", e.split.train.size()},
                {"heldout", e.split.heldout.size()},
                {"holdout_every", e.split.holdout_every}};
  j["surfels"] = e.surfels;
  j["definitions"] = definitions(e);
  if (!e.not_measured.empty()) j["not_measured"] = e.not_measured;
  return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string per_view_csv(const Evaluation& e) {
  std::string csv = "name,set,psnr,ssim,flip,lpips";
  for (std::string_view region : kRegions) csv += fmt::format(",psnr_{}", region);
  csv += ",rotation_deg,centre_rel,normal_mae_deg,depth_rel,neutral_shift\n";
  const auto number = [](std::optional<double> v) {
    return v && std::isfinite(*v) ? fmt::format(",{:.6g}", *v) : std::string(",");
  };
  for (const ViewScore& v : e.views) {
    csv += csv_field(v.name) + (v.heldout ? ",heldout" : ",train") + number(v.psnr) + number(v.ssim) + number(v.flip) +
           number(v.lpips);
    for (std::string_view region : kRegions) {
      const RegionError* error = found(v.regions, std::string(region));
      csv += number(error != nullptr ? std::optional(error->squared.psnr()) : std::nullopt);
    }
    csv += number(v.pose ? std::optional(v.pose->rotation_deg) : std::nullopt);
    csv += number(v.pose ? std::optional(v.pose->centre_rel) : std::nullopt);
    csv += number(v.normal_mae_deg) + number(v.zdepth_rel) + number(v.neutral_shift) + "\n";
  }
  return csv;
}

std::string summary_line(const Evaluation& e) {
  std::string line;
  if (const auto m = mean_score(e, true))
    line = fmt::format("PSNR {:.2f} dB, SSIM {:.3f}, FLIP {:.3f} over {} held-out views", m->psnr, m->ssim, m->flip, m->views);
  else if (const auto train = mean_score(e, false))
    line = fmt::format("training views only: PSNR {:.2f} dB, SSIM {:.3f}, FLIP {:.3f}", train->psnr, train->ssim, train->flip);
  if (!e.truth) return line;
  const TruthScores& t = *e.truth;
  if (t.normal_mae_deg) line += fmt::format(", normals {:.1f} deg", *t.normal_mae_deg);
  if (t.mesh) line += fmt::format(", F-score {:.3f}", t.mesh->fscore);
  if (t.transmitted_psnr) line += fmt::format(", behind glass {:.2f} dB", *t.transmitted_psnr);
  if (t.clear_psnr) line += fmt::format(", without medium {:.2f} dB", *t.clear_psnr);
  if (t.albedo && t.albedo->psnr) line += fmt::format(", albedo {:.2f} dB", *t.albedo->psnr);
  if (const auto relit = mean_relit_psnr(t)) line += fmt::format(", relit {:.2f} dB", *relit);
  return line;
}

}  // namespace vitrine
