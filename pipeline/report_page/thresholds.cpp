#include "pipeline/report_page/thresholds.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"

namespace vitrine {

namespace {

constexpr Rule kRules[] = {
    // --- photos and poses
    {"registered", "Photos that found their place", "%", 0, 0.9, 0.6, "Share of the photos whose camera position was found.",
     "The others are not used at all: they share too little with their neighbours."},
    {"reprojection", "Reprojection error", "px", 2, 1.0, 1.5,
     "How far the sparse points land from where they were seen, in pixels of the photos, mean.",
     "Poses are soft: blur, a moving object, or a lens that the camera model does not fit."},
    {"observations", "Points seen per photo", "", 0, 300, 100, "Sparse points that a photo sees, median over the photos.",
     "Few points hold a pose: plain surfaces or little overlap."},
    // --- pictures from new places
    {"psnr", "New views, PSNR", "dB", 1, 27, 22,
     "Photos that training never saw against their renders; mean over the held-out views.",
     "Pictures from new places are soft or wrong in parts."},
    {"ssim", "New views, SSIM", "", 3, 0.88, 0.75, "The same pictures, structure instead of error; 1 is equal.",
     "Fine structure is lost in pictures from new places."},
    {"gap", "Training against new views", "dB", 1, 3, 6, "By how much training photos come out better than held-out ones.",
     "The scene knows its photos by heart: too few of them agree on what is seen from elsewhere."},
    {"weakest", "Weakest new view", "dB", 1, 3, 6, "How far the worst held-out view lies below the mean.",
     "One side is much weaker than the others: more photos are missing there."},
    // --- parts of the picture
    {"region_rest", "Everything else", "dB", 1, 27, 22, "Held-out PSNR of what is neither glass nor gloss.",
     "Even plain surfaces are soft from new places."},
    {"region_object", "The object", "dB", 1, 27, 22, "Held-out PSNR inside the object masks.",
     "The object itself is soft from new places."},
    {"region_transparent", "Glass", "dB", 1, 27, 22, "Held-out PSNR inside the masks of glass.",
     "What stands behind the glass, or its reflections, is not yet understood."},
    {"region_reflective", "Metal and gloss", "dB", 1, 27, 22, "Held-out PSNR of what is glossy and not glass.",
     "Reflections are baked in or smeared."},
    // --- geometry
    {"normals_known", "Surface known before training", "%", 0, 0.6, 0.3,
     "Share of the pixels with a normal from stereo, hulls, files or a network.",
     "Training begins with little knowledge of the surface: plain or shiny areas."},
    {"mesh_border", "Open edges of the mesh", "%", 1, 0.04, 0.1,
     "Share of the edges with a face on one side only. A room is open by nature.",
     "Holes and ragged ends: places that few photos saw."},
    {"mesh_crossing", "Faces that cut each other", "", 0, 0, 100, "Self-intersections of the cleaned mesh.",
     "Boolean operations and printing may stumble over them."},
    {"mesh_nonmanifold", "Edges of more than two faces", "", 0, 0, 10, "Non-manifold edges of the cleaned mesh.",
     "Some programs refuse such a mesh."},
    // --- light
    {"baked", "Light that stays baked in", "log", 2, 0.3, 0.6,
     "Photo against albedo times light, rms of the logarithm: what a new light will not move. Gloss and glass above all.",
     "Highlights and what glass shows keep the light of the photos under a new one."},
    {"misfit", "Light and albedo against the colours", "log", 2, 0.3, 0.6,
     "What albedo times light leaves unexplained on the surface, rms of the logarithm.",
     "Shadows or colours of the light may have ended in the albedo."},
    // --- against truth, when there is one
    {"truth_rotation", "Camera directions", "deg", 2, 0.5, 2, "Against the truth after alignment, median.", "Poses are off."},
    {"truth_centre", "Camera positions", "%", 2, 0.005, 0.02, "Against the truth, relative to the camera ring, median.",
     "Poses are off."},
    {"truth_normals", "Normals", "deg", 1, 10, 20, "Mean angle to the true surface, outside glass.",
     "Surfaces are bumpy or lie wrong."},
    {"truth_depth", "Depth", "%", 2, 0.01, 0.03, "Relative to the truth, median.", "Surfaces lie in the wrong place."},
    {"truth_fscore", "Mesh, F-score", "", 3, 0.95, 0.8, "Share of the surface within 1 % of the diagonal, both ways.",
     "Parts of the surface are missing or stand where nothing is."},
    {"truth_transmitted", "Seen through glass", "dB", 1, 25, 20, "What the rays found behind the glass against the truth.",
     "What stands behind the glass is not yet right."},
    {"truth_albedo", "Albedo", "dB", 1, 25, 20, "Against the true albedo, one factor per channel for the whole scene.",
     "Light remains in the albedo."},
    {"truth_relit", "Under other lights", "dB", 1, 25, 20, "Pictures under new lights against the truth.",
     "Under a new light the scene will look off."},
};

// Shares are stored as fractions and shown in percent.
std::string number_text(const Rule& rule, double value, int decimals) {
  const bool percent = rule.unit == "%";
  std::string text = fmt::format("{:.{}f}", percent ? 100 * value : value, decimals);
  if (rule.unit.empty()) return text;
  return text + "\u00a0" + std::string(rule.unit);
}

std::string limit_text(const Rule& rule, double limit) {
  const double value = rule.unit == "%" ? 100 * limit : limit;
  std::string text = fmt::format("{:g}", value);
  return rule.unit.empty() ? text : text + "\u00a0" + std::string(rule.unit);
}

}  // namespace

std::string_view name(Rating rating) {
  constexpr std::array<std::string_view, 4> kNames = {"good", "borderline", "bad", "unknown"};
  return kNames[size_t(rating)];
}

std::span<const Rule> rules() { return kRules; }

const Rule& rule(std::string_view id) {
  const auto found = std::find_if(std::begin(kRules), std::end(kRules), [&](const Rule& r) { return r.id == id; });
  VITRINE_CHECK(found != std::end(kRules), "no rule '{}'", id);
  return *found;
}

Rating rate(const Rule& r, double value) {
  const double sign = r.good > r.okay ? 1 : -1;
  if (sign * value >= sign * r.good) return Rating::Good;
  return sign * value >= sign * r.okay ? Rating::Borderline : Rating::Bad;
}

double place_on_scale(const Rule& r, double value) {
  constexpr double kMargin = 0.03;
  return std::clamp((1 + (value - r.okay) / (r.good - r.okay)) / 3, kMargin, 1 - kMargin);
}

std::string shown(const Rule& r, double value) {
  return std::isfinite(value) ? number_text(r, value, r.decimals) : std::string("–");
}

std::string thresholds_text(const Rule& r) {
  const std::string_view word = r.good > r.okay ? "from" : "up to";
  return fmt::format("good {} {}, borderline {} {}", word, limit_text(r, r.good), word, limit_text(r, r.okay));
}

}  // namespace vitrine
