#include "stages/sfm/diagnosis.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/vec.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

namespace {

constexpr size_t kFewFeatures = 150;   // a sharp, textured photo of 1000 pixels has thousands
constexpr size_t kHardlyEnough = 400;  // features per photo, below which blur may be the cause
constexpr size_t kSmallestModel = 3;   // two views do not make a reliable model
// Share of the pairs with enough raw matches that pass the geometric verification. Below it the matches lie on surfaces that move
// with the camera (reflections) or are repetitive.
constexpr double kFewSurvive = 0.3;
constexpr double kBlurred = 0.8;        // px of edge blur that explains few features
constexpr double kOtherExposure = 1.5;  // EV from the median; SIFT tolerates less
constexpr double kManyPhotos = 0.25, kMostPhotos = 0.5;
constexpr double kMostPairs = 0.6;
constexpr double kFewAgree = 0.12;    // of the features of a photo, verified with its best partner
constexpr double kFewTogether = 0.3;  // of the photos connected by pairs: below, the pairs contradict each other
constexpr double kGroupPhotos = 3;    // photos; a group of this size would be a model of its own

constexpr double kRotationSlack = 0.06;  // of the entries of R^T R - I, root of the sum of squares; noise of a few pixels
constexpr double kTurnDeg = 1;           // minimum rotation angle

// Deviation of K^-1 H K, scaled to determinant 1, from a rotation; `turn_deg` is its angle.
double off_rotation(const std::vector<double>& h, double focal, double cx, double cy, double& turn_deg) {
  const auto column = [&](size_t c) { return Vec3d{h[c], h[3 + c], h[6 + c]}; };
  const Mat3d k{{focal, 0, 0}, {0, focal, 0}, {cx, cy, 1}};
  const Mat3d inverse{{1 / focal, 0, 0}, {0, 1 / focal, 0}, {-cx / focal, -cy / focal, 1}};
  Mat3d r = inverse * Mat3d{column(0), column(1), column(2)} * k;
  const double scale = std::cbrt(determinant(r));
  if (!(std::abs(scale) > 0)) return 1e9;
  r = {r.c0 / scale, r.c1 / scale, r.c2 / scale};
  const Mat3d s = transposed(r) * r;
  double sum = 0;
  for (const Vec3d& e : {s.c0 - Vec3d{1, 0, 0}, s.c1 - Vec3d{0, 1, 0}, s.c2 - Vec3d{0, 0, 1}}) sum += dot(e, e);
  constexpr double kDegree = 57.29577951308232;
  turn_deg = std::acos(std::clamp((r.c0.x + r.c1.y + r.c2.z - 1) / 2, -1.0, 1.0)) * kDegree;
  return std::sqrt(sum);
}

template <class F>
std::optional<double> median_of(const Reconstruction& r, F&& figure) {
  std::vector<double> v;
  for (const PhotoReport& p : r.photos)
    if (const std::optional<double> x = figure(p)) v.push_back(*x);
  if (v.empty()) return std::nullopt;
  return upper_median(std::move(v));
}

// Median number of features per photo: all, or only those not masked.
size_t median_features(const Reconstruction& r, bool masked_too) {
  const auto features = [&](const PhotoReport& p) {
    return std::optional(double(masked_too ? p.features : p.features - p.masked));
  };
  return size_t(median_of(r, features).value_or(0));
}

template <class F>
double share_of(const Reconstruction& r, F&& holds) {
  const auto count = std::count_if(r.photos.begin(), r.photos.end(), holds);
  return r.photos.empty() ? 0 : double(count) / double(r.photos.size());
}

// Share of the features of a photo that are verified with its best partner; median over the photos.
std::optional<double> agreeing_share(const Reconstruction& r) {
  if (r.pairs.empty()) return std::nullopt;
  std::vector<size_t> best(r.photos.size(), 0);
  for (const PairReport& p : r.pairs)
    for (size_t i : {p.a, p.b}) best[i] = std::max(best[i], p.verified);
  size_t i = 0;
  return median_of(r, [&](const PhotoReport& p) {
    const size_t matched = best[i++], used = p.features - p.masked;
    return used > 0 ? std::optional(double(matched) / double(used)) : std::nullopt;
  });
}

bool blurred(const PhotoReport& p) { return p.blur_px.value_or(0) > kBlurred; }

std::optional<double> median_brightness(const Reconstruction& r) {
  return median_of(r, [](const PhotoReport& p) { return p.brightness_ev; });
}
bool otherwise_exposed(const PhotoReport& p, std::optional<double> typical) {
  return typical && p.brightness_ev && std::abs(*p.brightness_ev - *typical) > kOtherExposure;
}

std::string sizes_text(const std::vector<size_t>& groups) {
  constexpr size_t kShown = 8;
  std::string sizes;
  for (size_t i = 0; i < std::min(groups.size(), kShown); ++i) sizes += (i ? ", " : "") + std::to_string(groups[i]);
  return sizes + (groups.size() > kShown ? ", ..." : "");
}

std::string left_out_list(const Reconstruction& r) {
  constexpr size_t kListed = 6;
  std::string out;
  size_t n = 0;
  for (const PhotoReport& p : r.photos) {
    const std::string reason = reason_left_out(p);
    if (reason.empty()) continue;
    if (++n <= kListed) out += fmt::format("\n{} ({})", p.name, reason);
  }
  if (n > kListed) out += fmt::format("\nand {} more (report.json)", n - kListed);
  return out;
}

}  // namespace

double rotation_share(std::span<const VerifiedPair> pairs, int width, int height) {
  if (pairs.empty()) return 0;
  const double longest = std::max(width, height);
  size_t best = 0;
  constexpr double kWidest = 0.4, kNarrowest = 6, kStep = 1.1;  // focal lengths over the longest side
  for (double f = kWidest; f < kNarrowest; f *= kStep) {
    size_t explained = 0;
    for (const VerifiedPair& p : pairs) {
      if (p.config < kFirstPlanarPair || p.config > kLastPlanarPair || p.homography.empty()) continue;
      double turn = 0;
      const double off = off_rotation(p.homography, f * longest, 0.5 * width, 0.5 * height, turn);
      explained += off < kRotationSlack && turn > kTurnDeg;
    }
    best = std::max(best, explained);
  }
  return double(best) / double(pairs.size());
}

std::string reason_left_out(const PhotoReport& p) {
  if (p.registered) return {};
  if (p.pose_missing) return "no pose was given for it";
  if (p.other_pass) return "taken in another pass, which shares too little of the object with the largest one";
  if (p.weak_points) return fmt::format("its pose would hang on {} points only", *p.weak_points);
  if (p.masked > 0 && p.features - p.masked < kFewFeatures)
    return fmt::format("{} features, {} of them masked", p.features, p.masked);
  if (p.features < kFewFeatures) return fmt::format("{} features: blurred, dark or without texture", p.features);
  if (p.matches < kMinMatches) return fmt::format("{} features, nothing like them in other photos", p.features);
  if (p.neighbours == 0) return fmt::format("{} matches, none agree on a camera motion", p.matches);
  return fmt::format("{} verified matches with {} photos, too few with known points", p.verified, p.neighbours);
}

std::string cause_left_out(const PhotoReport& p, const Reconstruction& r) {
  if (p.registered || p.pose_missing || p.other_pass) return {};
  const std::optional<double> typical = median_brightness(r);
  const bool few = p.features - p.masked < kFewFeatures, alone = p.matches < kMinMatches || p.neighbours == 0;
  if ((few || alone) && otherwise_exposed(p, typical)) return "mixed_exposure";
  if ((few || alone) && blurred(p)) return "motion_blur";
  if (few) return "too_few_features";
  if (p.group > 0 && p.group < r.groups.size() && double(r.groups[p.group]) >= kGroupPhotos) return "split_models";
  if (p.matches >= kMinMatches && p.neighbours == 0) return "reflections_dominate";
  return "no_overlap";
}

Diagnosis diagnosed(const Reconstruction& r, const SfmConfig& config) {
  const size_t have = r.model.images.size();
  const auto n = size_t(std::count_if(r.photos.begin(), r.photos.end(), [](const PhotoReport& p) { return !p.other_pass; }));
  // The mapper reconstructs false depth from photos of one position: its model does not count.
  const bool turned = r.rotation_share >= kMostPairs;
  if (have >= kSmallestModel && double(have) >= config.min_registered * double(n) && !turned) return {};
  Diagnosis d;
  const size_t median = median_features(r, false), found = median_features(r, true), largest = r.groups.empty() ? 0 : r.groups[0];
  const std::string of_found = found > median ? fmt::format(" ({} before masks)", found) : "";
  const std::string figures =
      fmt::format("median {} features a photo{}; of {} pairs compared {} had at least {} matches and {} agree on a camera motion",
                  median, of_found, r.pairs_compared, r.pairs_matched, kMinMatches, r.pairs_verified);
  const double survive = r.pairs_matched > 0 ? double(r.pairs_verified) / double(r.pairs_matched) : 0;
  const double needed = std::max(double(kSmallestModel), config.min_registered * double(n));
  const bool connected = double(largest) >= needed;
  const bool split = r.groups.size() >= 2 && double(r.groups[1]) >= kGroupPhotos;
  const std::string poses_hint = "3. supply poses: --poses transforms.json, or a COLMAP model";
  const std::optional<double> typical = median_brightness(r), blur = median_of(r, [](const PhotoReport&p) { return p.blur_px; });
  const double exposed = share_of(r, [&](const PhotoReport& p) { return otherwise_exposed(p, typical); });
  if (median < kFewFeatures && found >= kFewFeatures) {
    d.code = "SFM_TOO_FEW_FEATURES";
    d.why = "the masks leave too little texture: " + figures;
    d.hint =
        "1. look at the masks: features are not used inside specular, transparent and ignore, on a turntable outside object\n"
        "2. find the cameras without masks of a class: --set sfm.masks.specular=off (object, transparent, ignore)\n" +
        poses_hint;
  } else if (exposed >= kManyPhotos) {
    d.code = "SFM_MIXED_EXPOSURE";
    d.why = fmt::format("{:.0f} % of the photos are more than {} EV brighter or darker than the others, too much to match: {}",
                        100 * exposed, kOtherExposure, figures);
    d.hint =
        "1. manual exposure: one time, one aperture, one ISO for all photos; `vitrine inspect PHOTOS -v` lists them\n"
        "2. develop the raw files again with one exposure\n" +
        poses_hint;
  } else if (median < kHardlyEnough && share_of(r, blurred) >= kMostPhotos) {
    d.code = "SFM_MOTION_BLUR";
    d.why = fmt::format("the photos are blurred: edges are smeared over {:.1f} pixels; {}", blur.value_or(0), figures);
    d.hint =
        "1. tripod or more light, and take them again; `vitrine inspect PHOTOS` says which are sharp\n"
        "2. smaller pictures hide some of it: --set ingest.max_side=800\n" +
        poses_hint;
  } else if (median < kFewFeatures) {
    d.code = "SFM_TOO_FEW_FEATURES";
    d.why = "the photos hold too little texture: " + figures;
    d.hint =
        "1. sharper, brighter photos, and keep the background (do not cut the object out)\n"
        "2. put the object on a printed pattern or newspaper\n" +
        poses_hint;
  } else if (turned) {
    d.code = "SFM_PURE_ROTATION";
    d.why = fmt::format("the camera turned but did not move: that explains {:.0f} % of the pairs; {}", 100 * r.rotation_share,
                        figures);
    d.hint =
        "1. walk around the scene: depth shows only from different places, a step for every photo\n"
        "2. a turntable? give masks of the object: --masks DIR --set sfm.turntable=yes\n" +
        poses_hint;
  } else if (r.uncalibrated_share >= kMostPairs && have == 0) {
    d.code = "SFM_BAD_FOCAL";
    d.why =
        fmt::format("{:.0f} % of the pairs contradict the focal length that EXIF names (cropped, resized or edited photos?); {}",
                    100 * r.uncalibrated_share, figures);
    d.hint =
        "1. use the photos as the camera wrote them\n"
        "2. or remove their EXIF data, so that the focal length is solved for: exiftool -all= PHOTOS\n" +
        poses_hint;
  } else if (!connected && split) {
    d.code = "SFM_SPLIT_MODELS";
    d.why = fmt::format("the photos are of {} places that share nothing (groups of {} photos): {}", r.groups.size(),
                        sizes_text(r.groups), figures);
    d.hint =
        "1. take a few photos that show both parts, or run each part by itself\n"
        "2. take the largest group as it is: --set sfm.min_registered=0.3\n" +
        poses_hint;
  } else if (!connected && (survive >= kFewSurvive || r.pairs_matched == 0)) {
    d.code = "SFM_NO_OVERLAP";
    d.why = r.pairs_matched == 0 ? "no photo shows what another shows: " + figures
                                 : fmt::format("the photos fall into {} groups that share nothing (sizes {}): {}",
                                               r.groups.size(), sizes_text(r.groups), figures);
    d.hint =
        "1. take more photos in between: two thirds of a picture should be seen in the next one, steps of 10-15 degrees\n"
        "2. shiny object or plain table: put a printed pattern under it, and keep the surroundings in the picture\n" +
        poses_hint;
  } else if (!connected || (r.pairs_matched > 0 && survive < kFewSurvive) ||
             (have > 0 && double(have) < kFewTogether * double(largest)) || agreeing_share(r).value_or(1) < kFewAgree) {
    // Pairs that are consistent two by two but not with one scene: their content moves with the camera.
    d.code = "SFM_REFLECTIONS_DOMINATE";
    d.why = (connected && survive >= kFewSurvive
                 ? "the photos agree two by two, but not on one scene, as when most matches lie on polished surfaces, whose "
                   "reflections move with the camera (or on repeated patterns): "
                 : "most matches disagree with every camera motion, as on polished surfaces, whose reflections move with the "
                   "camera (or on repeated patterns): ") +
            figures;
    d.hint =
        "1. put a printed pattern under the object, and keep more of the surroundings in the picture\n"
        "2. mark the shiny parts: --masks marks.yaml (stages/masks/README.md), or a folder of masks\n" +
        poses_hint;
  } else if (have == 0) {
    d.code = "SFM_NO_MODEL";
    d.why = "no two photos make a sound start (enough matches, seen under enough angle): " + figures;
    d.hint =
        "1. move the camera between photos instead of turning it on the spot\n"
        "2. take more photos with smaller steps\n" +
        poses_hint;
  } else {
    d.code = "SFM_TOO_FEW_REGISTERED";
    d.why = figures;
    d.hint =
        "1. add photos between those with a pose and those without\n"
        "2. put a printed pattern under the object, keep the surroundings in the picture\n" +
        poses_hint + "\n4. accept fewer: --set sfm.min_registered=0.3";
  }
  d.message = have == 0 ? fmt::format("none of {} photos got a camera pose", n)
                        : fmt::format("{} of {} photos have poses ({:.0f} %, need {:.0f} % and at least {})", have, n,
                                      100.0 * double(have) / double(n), 100 * config.min_registered, kSmallestModel);
  if (turned && have > 0)
    d.message = fmt::format("the poses of {} photos cannot be trusted: they were all taken from one place", have);
  if (r.attempts.size() > 1) d.why += fmt::format("; {} attempts were made", r.attempts.size());
  d.why += left_out_list(r);
  return d;
}

namespace {

// Further lines start below the first one (core/foundation/base/error.cpp puts nine columns before it).
std::string indented(const std::string& text) {
  std::string out;
  for (char c : text) out += c == '\n' ? std::string("\n         ") : std::string(1, c);
  return out;
}

}  // namespace

void throw_diagnosis(const Diagnosis& d, const std::filesystem::path& where) {
  throw Error(ErrorKind::SfmFailed, d.message,
              {.where = where.string(), .why = indented(d.why), .hint = indented(d.hint), .code = d.code});
}

}  // namespace vitrine
