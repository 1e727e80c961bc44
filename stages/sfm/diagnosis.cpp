#include "stages/sfm/diagnosis.h"

#include <algorithm>

#include "core/base/error.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

namespace {

constexpr size_t kFewFeatures = 150;  // a sharp, textured photo of 1000 pixels has thousands
constexpr size_t kSmallestModel = 3;  // two views are a guess, not a model
// Of pairs with enough raw matches: when fewer survive the geometric check than this, the matches lie on things that move with
// the camera (reflections) or look alike (repetition).
constexpr double kFewSurvive = 0.3;

// Of the features that the masks leave, or of all.
size_t median_features(const Reconstruction& r, bool masked_too) {
  std::vector<size_t> f;
  for (const PhotoReport& p : r.photos) f.push_back(masked_too ? p.features : p.features - p.masked);
  if (f.empty()) return 0;
  std::nth_element(f.begin(), f.begin() + long(f.size() / 2), f.end());
  return f[f.size() / 2];
}

std::string left_out_list(const Reconstruction& r, const SfmConfig& config) {
  constexpr size_t kListed = 6;
  std::string out;
  size_t n = 0;
  for (const PhotoReport& p : r.photos) {
    const std::string reason = reason_left_out(p, config);
    if (reason.empty()) continue;
    if (++n <= kListed) out += fmt::format("\n{} ({})", p.name, reason);
  }
  if (n > kListed) out += fmt::format("\nand {} more (report.json)", n - kListed);
  return out;
}

}  // namespace

std::string reason_left_out(const PhotoReport& p, const SfmConfig& config) {
  if (p.registered) return {};
  if (p.pose_missing) return "no pose was given for it";
  if (p.weak_points) return fmt::format("its pose would hang on {} points only", *p.weak_points);
  if (p.masked > 0 && p.features - p.masked < kFewFeatures)
    return fmt::format("{} features, {} of them masked", p.features, p.masked);
  if (p.features < kFewFeatures) return fmt::format("{} features: blurred, dark or without texture", p.features);
  if (p.matches < size_t(config.min_matches)) return fmt::format("{} features, nothing like them in other photos", p.features);
  if (p.neighbours == 0) return fmt::format("{} matches, none agree on a camera motion", p.matches);
  return fmt::format("{} verified matches with {} photos, too few with known points", p.verified, p.neighbours);
}

Diagnosis diagnosed(const Reconstruction& r, const SfmConfig& config) {
  const size_t n = r.photos.size(), have = r.model.images.size();
  if (have >= kSmallestModel && double(have) >= config.min_registered * double(n)) return {};
  Diagnosis d;
  const size_t median = median_features(r, false), found = median_features(r, true), largest = r.groups.empty() ? 0 : r.groups[0];
  const std::string of_found = found > median ? fmt::format(" ({} before masks)", found) : "";
  const std::string figures =
      fmt::format("median {} features a photo{}; of {} pairs compared {} had at least {} matches and {} agree on a camera motion",
                  median, of_found, r.pairs_compared, r.pairs_matched, config.min_matches, r.pairs_verified);
  const double survive = r.pairs_matched > 0 ? double(r.pairs_verified) / double(r.pairs_matched) : 0;
  const std::string poses_hint = "3. supply poses: --poses transforms.json, or a COLMAP model";
  if (median < kFewFeatures && found >= kFewFeatures) {
    d.code = "SFM_TOO_FEW_FEATURES";
    d.why = "the masks leave too little texture: " + figures;
    d.hint =
        "1. look at the masks: features are not used inside specular, transparent and ignore, on a turntable outside object\n"
        "2. find the cameras without masks of a class: --set sfm.masks.specular=off (object, transparent, ignore)\n" +
        poses_hint;
  } else if (median < kFewFeatures) {
    d.code = "SFM_TOO_FEW_FEATURES";
    d.why = "the photos hold too little texture: " + figures;
    d.hint =
        "1. sharper, brighter photos, and keep the background (do not cut the object out)\n"
        "2. put the object on a printed pattern or newspaper\n" +
        poses_hint;
  } else if (n >= 2 && double(largest) < std::max(double(kSmallestModel), config.min_registered * double(n))) {
    d.code = "SFM_NO_OVERLAP";
    std::string sizes;
    for (size_t i = 0; i < std::min<size_t>(r.groups.size(), 8); ++i) sizes += (i ? ", " : "") + std::to_string(r.groups[i]);
    if (r.groups.size() > 8) sizes += ", ...";
    d.why = fmt::format("the photos fall into {} groups that share nothing (sizes {}): {}", r.groups.size(), sizes, figures);
    if (survive < kFewSurvive && r.pairs_matched > 0)
      d.why +=
          ". Matches that disagree with every camera motion are typical of polished surfaces, whose reflections move with the "
          "camera";
    d.hint =
        "1. take more photos in between: two thirds of a picture should be seen in the next one, steps of 10-15 degrees\n"
        "2. shiny object or plain table: put a printed pattern under it, and keep the surroundings in the picture\n" +
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
    if (survive < kFewSurvive && r.pairs_matched > 0)
      d.why += ". Most matches disagree with every camera motion: polished surfaces or repeated patterns";
    d.hint =
        "1. add photos between those with a pose and those without\n"
        "2. put a printed pattern under the object, keep the surroundings in the picture\n" +
        poses_hint + "\n4. accept fewer: --set sfm.min_registered=0.3";
  }
  d.message = have == 0 ? fmt::format("none of {} photos got a camera pose", n)
                        : fmt::format("{} of {} photos have poses ({:.0f} %, need {:.0f} % and at least {})", have, n,
                                      100.0 * double(have) / double(n), 100 * config.min_registered, kSmallestModel);
  if (r.attempts.size() > 1) d.why += fmt::format("; {} attempts were made", r.attempts.size());
  d.why += left_out_list(r, config);
  return d;
}

namespace {

// Further lines start below the first one (core/base/error.cpp puts nine columns before it).
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
