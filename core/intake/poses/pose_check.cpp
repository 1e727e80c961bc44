#include "core/intake/poses/pose_check.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/intake/poses/pose_variants.h"

namespace vitrine {

namespace {

// Measured shares (stages/sfm/EXPERIMENTS.md):
//   matches      correct 0.94, off by 1 % of the longest side 0.75, other conventions 0.00 to 0.05, other photos 0.09 to 0.14,
//                shifted by one 0.39, twice the focal length 0.57
//   pictures     correct 0.98 and more, other photos 0.50 to 0.54, shifted by one 0.57
//   own points   correct 1
struct Scale {
  const char* tests;    // name of the tests, for messages
  double hardly, weak;  // below: rejected; a warning
  double fits;          // minimum share for accepting another convention
};
constexpr Scale kMatches{"verified matches", 0.3, 0.5, 0.5};
constexpr Scale kPictures{"comparisons of the photos at the model's points", 0.65, 0.8, 0.8};
constexpr Scale kOwnPoints{"observations of the model's own points", 0.5, 0.9, 0.8};

constexpr size_t kFewestTests = 60;        // minimum for a decision
constexpr size_t kMostTests = 15000;       // for every tried convention
constexpr double kSuspicious = 0.85;       // of matches: below this other conventions are tried
constexpr double kPhotoDisagrees = 0.3;    // matches
constexpr double kPhotoLooksOther = 0.65;  // pictures
constexpr size_t kNamed = 4;
constexpr double kClearly = 0.03;  // minimum difference of shares for preferring another convention

struct Fit {
  std::string what, hint;
  double share = 0;
};

using Measure = std::function<Agreement(const ColmapModel&)>;

// Keeps the best variant; a later (less simple) one only if it is clearly better.
void keep_best(const std::vector<PoseVariant>& variants, const Measure& measure, std::optional<Fit>& best) {
  for (const PoseVariant& v : variants) {
    const double share = measure(v.model).share();
    if (!best || share > best->share + kClearly) best = {v.what, v.hint, share};
  }
}

// Another convention is accepted when it fits and leaves at most a third of the failed tests.
bool convinces(const std::optional<Fit>& fit, double given, const Scale& scale) {
  constexpr double kLess = 3, kMore = 0.1;
  return fit && fit->share >= scale.fits && fit->share > given + kMore && 1 - given > kLess * (1 - fit->share);
}

// `fit`: the correct convention, or null.
[[noreturn]] void throw_disagree(const Agreement& given, const Fit* fit, const Scale& scale, const PosePixels& pixels,
                                 const std::string& more, const std::filesystem::path& where) {
  std::string why =
      fmt::format("{} of {} {} agree ({:.0f} %)", given.all.agree, given.all.tests, scale.tests, 100 * given.share());
  why += more;
  if (fit != nullptr)
    why += fmt::format("; {:.0f} % agree if {}", 100 * fit->share, fit->what);
  else
    why +=
        "; no other camera axes, inverse, order of the photos or focal length that was tried fits better: they may be of other "
        "photos";
  throw Error(ErrorKind::Input, "the given poses do not agree with the photos",
              {.where = where.string(),
               .why = why,
               .hint = fmt::format("{}. Or run without --poses: they are found from the photos then",
                                   fit != nullptr ? fit->hint : "give the poses of these photos; " + rule_of(pixels.source)),
               .code = "POSES_DISAGREE"});
}

void note_photos(const Agreement& agreement, const Scale& scale, double least, CheckedPoses& out) {
  const auto photos = disagreeing_photos(agreement, least);
  if (photos.empty()) return;
  std::string names;
  for (size_t i = 0; i < std::min(photos.size(), kNamed); ++i)
    names += fmt::format("{}{} ({} of {})", i > 0 ? ", " : "", photos[i].first, photos[i].second.agree, photos[i].second.tests);
  if (photos.size() > kNamed) names += fmt::format(" and {} more", photos.size() - kNamed);
  out.notes.push_back({"POSES_PHOTO_DISAGREES",
                       fmt::format("the poses of {} photos do not agree with the other photos, by {}: {}. Correct them, or leave "
                                   "these photos out",
                                   photos.size(), scale.tests, names)});
}

// Compares both orientations of the unsettled photos. Removes the note on the assumption once it is confirmed or overruled.
void settle_open(CheckedPoses& out, PosePixels& pixels, const Measure& measure) {
  if (!pixels.open()) return;
  PosePixels other_pixels = pixels;
  ColmapModel other = turned_other_way(out.model, other_pixels);
  const double as_assumed = out.agreement.share(), turned = measure(other).share();
  if (std::abs(turned - as_assumed) < kClearly) return;
  const bool changed = turned > as_assumed;
  if (changed) {
    pixels = std::move(other_pixels);
    out.model = std::move(other);
    out.agreement = measure(out.model);
  }
  std::erase_if(pixels.notes, [](const Note& n) { return n.code == "POSES_ORIENTATION"; });
  size_t open = 0;
  bool stored = false;
  for (PosedPhoto& p : pixels.photos)
    if (!p.settled) ++open, stored = p.for_stored, p.settled = true;
  out.notes.push_back(
      {"", fmt::format("EXIF turns {} photos; the photos show that the poses are for the pixels {} ({:.0f} % agree, "
                       "else {:.0f} %)",
                       open, stored ? "as stored: they are turned with the photos" : "as turned upright",
                       100 * std::max(turned, as_assumed), 100 * std::min(turned, as_assumed))});
}

std::string one_place(const ColmapModel& model) {
  constexpr double kRounding = 1e-9;  // of the distance from the origin: rounding error of a camera centre
  Bounds3 centres;
  double farthest = 0;
  for (const ColmapImage& image : model.images) {
    const Vec3d centre = inverse(image.cam_from_world()).translation;
    centres.extend(centre);
    farthest = std::max(farthest, length(centre));
  }
  return centres.diagonal() > kRounding * farthest ? "" : "; all cameras are at one place";
}

void note_accuracy(const Agreement& a, const ColmapModel& model, CheckedPoses& out) {
  uint64_t side = 0;
  for (const ColmapCamera& camera : model.cameras) side = std::max({side, camera.width, camera.height});
  // Poses estimated from photos are off by less than a pixel of 1000.
  constexpr double kRough = 0.0015, kRoughPx = 1.5;
  const bool few = a.share()<kMatches.weak, rough = a.offset> std::max(kRoughPx, kRough * double(side));
  if (!few && !rough) return;
  out.notes.push_back(
      {"POSES_INACCURATE",
       fmt::format("the poses are off by {:.1f} px in the median, and {:.0f} % of the verified matches agree with them "
                   "(poses found from photos: below 1 px): pictures will be soft. Without --poses they are found "
                   "from the photos",
                   a.offset, 100 * a.share())});
}

// A focal length for another picture size may keep most matches within the tolerance; the correct one has much smaller residuals.
void check_focal(const CheckedPoses& checked, const Measure& measure, const PosePixels& pixels,
                 const std::filesystem::path& where) {
  constexpr double kVisiblePx = 0.5, kMuchBetter = 0.4;
  const Agreement& given = checked.agreement;
  if (given.offset < kVisiblePx) return;
  Fit best;
  double offset = kMuchBetter * given.offset;
  for (const PoseVariant& focal : focal_variants(checked.model, pixels)) {
    const Agreement a = measure(focal.model);
    if (a.share() < given.share() || a.offset > offset) continue;
    offset = a.offset;
    best = {fmt::format("{} ({:.2f} instead of {:.2f} px off)", focal.what, a.offset, given.offset), focal.hint, a.share()};
  }
  if (best.share > 0) throw_disagree(given, &best, kMatches, pixels, "", where);
}

// For cameras of another picture size: compares resized with cropped.
void settle_resize(CheckedPoses& out, PosePixels& pixels, const Measure& measure, const std::filesystem::path& where) {
  constexpr double kBetter = 0.85;  // measured 0.80 and 1.3 with cameras for 312 x 234 of 320 x 240 pixels
  if (!pixels.oddly_resized) return;
  const Agreement cropped = measure(as_cropped(out.model, pixels));
  const Agreement& resized = out.agreement;
  log_debug("poses: resized {:.3f} {:.4f}, cropped {:.3f} {:.4f}", resized.share(), resized.offset, cropped.share(),
            cropped.offset);
  if (cropped.offset < kBetter * resized.offset && cropped.share() >= resized.share()) {
    const PosedPhoto& p = pixels.photos.front();
    throw Error(
        ErrorKind::Input, "the poses are of cropped or undistorted pictures, not of these photos",
        {.where = where.string(),
         .why = fmt::format("the cameras are for {:.0f} x {:.0f} pixels, and the photos fit them better as their middle part "
                            "than resized",
                            p.given.width, p.given.height),
         .hint = "give these pictures as photos, or poses with the lens model for the photos as taken",
         .code = "POSES_CROPPED"});
  }
  if (!(resized.offset < kBetter * cropped.offset && resized.share() >= cropped.share())) return;
  for (Note& n : pixels.notes)
    if (n.code == "POSES_RESIZED") n = {"", "the cameras are for another size: the photos fit them resized, not cropped"};
  pixels.oddly_resized = false;
}

}  // namespace

CheckedPoses checked_with_matches(ColmapModel model, PosePixels& pixels, std::span<const PhotoMatches> matches,
                                  const std::filesystem::path& where) {
  const std::vector<PhotoMatches> few = thinned(matches, kMostTests);
  const Measure measure = [&](const ColmapModel& m) { return matches_agreement(m, few); };
  CheckedPoses out{.model = std::move(model), .notes = {}, .agreement = {}};
  out.agreement = measure(out.model);
  if (out.agreement.all.tests < kFewestTests) {
    out.notes.push_back({"POSES_UNCHECKED", fmt::format("the photos have {} verified matches, too few to check the given poses",
                                                        out.agreement.all.tests)});
    return out;
  }
  out.checked = true;
  settle_open(out, pixels, measure);
  const double share = out.agreement.share();
  if (share < kSuspicious) {
    std::optional<Fit> best;
    keep_best(convention_variants(out.model, pixels), measure, best);
    keep_best(order_variants(out.model), measure, best);
    keep_best(focal_variants(out.model, pixels), measure, best);
    const Fit* const fit = convinces(best, share, kMatches) ? &*best : nullptr;
    if (fit != nullptr || share < kMatches.hardly) {
      if (fit == nullptr && best) log_debug("poses: at most {:.0f} % agree, if {}", 100 * best->share, best->what);
      throw_disagree(out.agreement, fit, kMatches, pixels, one_place(out.model), where);
    }
  }
  check_focal(out, measure, pixels, where);
  log_info("sfm: {} of {} verified matches agree with the given poses, {:.2f} px", out.agreement.all.agree,
           out.agreement.all.tests, out.agreement.offset);
  settle_resize(out, pixels, measure, where);
  note_accuracy(out.agreement, out.model, out);
  note_photos(out.agreement, kMatches, kPhotoDisagrees, out);
  return out;
}

CheckedPoses checked_with_pictures(ColmapModel model, PosePixels& pixels,
                                   const std::function<Image8(const ColmapImage&)>& picture, const std::filesystem::path& where) {
  CheckedPoses out{.model = std::move(model), .notes = {}, .agreement = {}};
  const Agreement own = own_points_agreement(out.model);
  if (own.all.tests >= kFewestTests && own.share() < kOwnPoints.weak) {
    std::optional<Fit> best;
    keep_best(convention_variants(out.model, pixels), own_points_agreement, best);
    keep_best(focal_variants(out.model, pixels), own_points_agreement, best);
    const Fit* const fit = convinces(best, own.share(), kOwnPoints) ? &*best : nullptr;
    if (fit != nullptr || own.share() < kOwnPoints.hardly)
      throw_disagree(own, fit, kOwnPoints, pixels, one_place(out.model), where);
    out.notes.push_back(
        {"POSES_INACCURATE", fmt::format("{} of {} observations of the model's own points lie where its poses put them",
                                         own.all.agree, own.all.tests)});
  }
  const TrackPictures pictures(out.model, picture);
  const Measure measure = [&](const ColmapModel& m) { return pictures.agreement(m); };
  out.agreement = measure(out.model);
  if (out.agreement.all.tests < kFewestTests) {
    out.notes.push_back(
        {"POSES_UNCHECKED", fmt::format("{} places can be compared between photos, too few to check that the given "
                                        "model is of these photos",
                                        out.agreement.all.tests)});
    return out;
  }
  out.checked = true;
  settle_open(out, pixels, measure);
  const double share = out.agreement.share();
  if (share < kSuspicious) {
    std::optional<Fit> best;
    keep_best(order_variants(out.model), measure, best);
    const Fit* const fit = convinces(best, share, kPictures) ? &*best : nullptr;
    if (fit != nullptr || share < kPictures.hardly) throw_disagree(out.agreement, fit, kPictures, pixels, "", where);
  }
  log_info("sfm: the photos look alike at the given model's points in {} of {} comparisons", out.agreement.all.agree,
           out.agreement.all.tests);
  settle_resize(out, pixels, measure, where);
  if (share < kPictures.weak)
    out.notes.push_back({"POSES_INACCURATE", fmt::format("at the given model's points the photos look alike in {:.0f} % of the "
                                                         "comparisons only (right poses: above 90 %)",
                                                         100 * share)});
  note_photos(out.agreement, kPictures, kPhotoLooksOther, out);
  return out;
}

}  // namespace vitrine
