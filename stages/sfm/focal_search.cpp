#include "stages/sfm/focal_search.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/log.h"
#include "core/foundation/math/median.h"
#include "stages/sfm/features.h"
#include "stages/sfm/gains/bundle.h"
#include "stages/sfm/mapping.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

namespace {

constexpr size_t kSmallestGroup = 3;  // photos
constexpr double kApart = 1.15, kWithin = 1.10, kGroupedShare = 0.75;
constexpr size_t kFewestMapped = 6;     // photos
constexpr int kFirstSteps = 10;         // of the adjustment, before it is known whether it helps
constexpr double kSuspicious = 0.9;     // of the error with common focal lengths
constexpr double kContradiction = 0.7;  // the same: worth a warning without groups
constexpr double kConfirmed = 0.9;      // of the error before, after the photos were mapped again
constexpr double kStillApart = 1.12;    // ratio of the focal lengths of separated cameras
constexpr int kMostRounds = 3;          // of grouping and mapping
constexpr double kDefaultFocal = 1.2;   // of the longest side; COLMAP's

// Photos that share a camera by EXIF and size, as indices.
using Family = std::vector<size_t>;

// Focal lengths of the photos [desc.photos] if each has its own; 0: not in the model.
struct OwnFocals {
  double before = 0, after = 0;  // errors
  std::vector<double> of_photo;
};

OwnFocals own_focals(const ReconstructDesc& desc, const ColmapModel& model, double needed) {
  OwnFocals out;
  ColmapModel trial = model;
  BundleAdjustment adjustment(trial, BundleAdjustment::Focals::OfPhotos);
  if (adjustment.observations() == 0) return out;
  out.before = adjustment.error();
  out.after = adjustment.solve(false, kFirstSteps);
  if (!(out.after <= needed * out.before)) return out;
  out.after = adjustment.solve(false, kBundleSteps - kFirstSteps);
  std::map<std::string, double> by_name;
  const std::vector<double> focals = adjustment.focals();
  for (size_t i = 0; i < focals.size(); ++i) by_name[model.images[i].name] = focals[i];
  for (const SfmPhoto& p : desc.photos) out.of_photo.push_back(by_name.contains(p.name) ? by_name.at(p.name) : 0);
  return out;
}

// The camera of these photos in the model, or COLMAP's default, with this focal length if it is not 0.
ColmapCamera start_camera(const SfmConfig& config, const ReconstructDesc& desc, const ColmapModel& model, const Family& photos,
                          double focal) {
  for (const ColmapImage& image : model.images) {
    if (std::ranges::none_of(photos, [&](size_t i) { return desc.photos[i].name == image.name; })) continue;
    ColmapCamera camera = *model.find_camera(image.camera_id);
    if (focal == 0) return camera;
    const size_t focals = focal_count(camera);
    std::fill_n(camera.params.begin(), focals, focal);
    std::fill(camera.params.begin() + long(focals + 2), camera.params.end(), 0);
    return camera;
  }
  const SfmPhoto& p = desc.photos[photos[0]];
  const ColmapCameraType& type = *colmap_camera_type(config.camera_model);
  ColmapCamera camera{.id = 1, .model_id = type.id, .width = uint64_t(p.width), .height = uint64_t(p.height), .params = {}};
  if (focal == 0) focal = p.focal_px.value_or(kDefaultFocal * std::max(p.width, p.height));
  camera.params.assign(type.parameter_count, 0);
  const size_t focals = focal_count(camera);
  std::fill_n(camera.params.begin(), focals, focal);
  camera.params[focals] = 0.5 * p.width, camera.params[focals + 1] = 0.5 * p.height;
  return camera;
}

struct Parted {
  std::vector<CameraOfPhotos> cameras;
  std::vector<size_t> family;  // [camera] index of its family
  std::vector<Family> lists() const {
    std::vector<Family> out;
    for (const CameraOfPhotos& c : cameras) out.push_back(c.photos);
    return out;
  }
};

// A camera for each group of focal lengths in each family. Photos without a pose in a family with groups get one each.
Parted parted(const SfmConfig& config, const ReconstructDesc& desc, const ColmapModel& model, std::span<const Family> families,
              std::span<const double> focals) {
  Parted out;
  const auto add = [&](size_t family, double focal, bool trusted, Family photos) {
    const ColmapCamera start = start_camera(config, desc, model, families[family], focal);
    out.cameras.push_back({.start = start, .trusted = trusted, .photos = std::move(photos)});
    out.family.push_back(family);
  };
  for (size_t f = 0; f < families.size(); ++f) {
    const Family& family = families[f];
    std::vector<double> known, positive;
    for (const size_t i : family) {
      known.push_back(focals[i]);
      if (focals[i] > 0) positive.push_back(focals[i]);
    }
    const std::vector<FocalGroup> groups = focal_groups(known);
    if (groups.empty()) {
      add(f, 0, !positive.empty(), family);
      continue;
    }
    for (const FocalGroup& g : groups) {
      Family photos;
      for (const size_t m : g.members) photos.push_back(family[m]);
      add(f, g.focal, true, std::move(photos));
    }
    for (size_t m = 0; m < family.size(); ++m)
      if (known[m] == 0) add(f, upper_median(positive), false, {family[m]});
  }
  return out;
}

uint32_t camera_id_of(const ReconstructDesc& desc, const ColmapModel& model, const Family& photos) {
  for (const ColmapImage& image : model.images)
    if (std::ranges::any_of(photos, [&](size_t i) { return desc.photos[i].name == image.name; })) return image.camera_id;
  return 0;
}

// Cameras of separated families as they came out of the mapping; empty if two of a family are too near to each other.
std::vector<FocalSearch::Group> groups_of(const ReconstructDesc& desc, const ColmapModel& model, const Parted& parts) {
  std::vector<FocalSearch::Group> out;
  std::map<size_t, std::vector<double>> of_family;
  for (size_t c = 0; c < parts.cameras.size(); ++c) {
    const Family& photos = parts.cameras[c].photos;
    if (std::ranges::count(parts.family, parts.family[c]) < 2 || !parts.cameras[c].trusted) continue;
    const ColmapCamera* camera = model.find_camera(camera_id_of(desc, model, photos));
    if (camera == nullptr) continue;
    out.push_back({camera->params[0], photos.size()});
    of_family[parts.family[c]].push_back(camera->params[0]);
  }
  for (auto& [family, focals] : of_family) {
    std::ranges::sort(focals);
    if (focals.size() < 2) return {};
    for (size_t i = 1; i < focals.size(); ++i)
      if (focals[i] < kStillApart * focals[i - 1]) return {};
  }
  std::ranges::sort(out, {}, &FocalSearch::Group::focal_px);
  return out;
}

// Photos that had a camera each to be mapped take that of the group to which they belong by `now`; the bundle is adjusted again.
void join_groups(const ReconstructDesc& desc, const Parted& now, Parted& chosen, ColmapModel& model) {
  bool joined = false;
  for (size_t s = 0; s < chosen.cameras.size(); ++s) {
    if (chosen.cameras[s].trusted) continue;
    const size_t photo = chosen.cameras[s].photos[0];
    const auto with_photo = [&](const CameraOfPhotos& c) { return std::ranges::count(c.photos, photo) > 0; };
    const auto group = std::ranges::find_if(now.cameras, with_photo);
    const auto common = [&](const CameraOfPhotos& c) {
      return std::ranges::count_if(c.photos, [&](size_t i) { return std::ranges::count(group->photos, i) > 0; });
    };
    size_t best = s;
    for (size_t c = 0; c < chosen.cameras.size(); ++c)
      if (chosen.cameras[c].trusted && chosen.family[c] == chosen.family[s] &&
          common(chosen.cameras[c]) > (best == s ? 0 : common(chosen.cameras[best])))
        best = c;
    if (best == s) continue;
    const uint32_t camera = camera_id_of(desc, model, chosen.cameras[best].photos);
    for (ColmapImage& image : model.images)
      if (camera != 0 && image.name == desc.photos[photo].name) image.camera_id = camera, joined = true;
    Family& photos = chosen.cameras[best].photos;
    photos.insert(std::ranges::upper_bound(photos, photo), photo);
    chosen.cameras[s].photos.clear();
  }
  for (size_t s = chosen.cameras.size(); s-- > 0;)
    if (chosen.cameras[s].photos.empty())
      chosen.cameras.erase(chosen.cameras.begin() + long(s)), chosen.family.erase(chosen.family.begin() + long(s));
  if (!joined) return;
  std::erase_if(model.cameras, [&](const ColmapCamera& camera) {
    return std::ranges::none_of(model.images, [&](const ColmapImage& image) { return image.camera_id == camera.id; });
  });
  BundleAdjustment adjustment(model);
  adjustment.solve(false);
  adjustment.finish();
}

double error_of(const ColmapModel& model) {
  ColmapModel copy = model;
  BundleAdjustment adjustment(copy);
  return adjustment.observations() > 0 ? adjustment.error() : HUGE_VAL;
}

}  // namespace

std::vector<FocalGroup> focal_groups(std::span<const double> focals) {
  std::vector<size_t> order;
  for (size_t i = 0; i < focals.size(); ++i)
    if (focals[i] > 0) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](size_t i) { return focals[i]; });
  // Runs without a gap of half the distance between groups.
  std::vector<FocalGroup> groups;
  const double gap = std::sqrt(kApart);
  for (size_t first = 0, i = 0; i < order.size(); ++i) {
    if (i + 1 < order.size() && focals[order[i + 1]] <= gap * focals[order[i]]) continue;
    if (i + 1 - first >= kSmallestGroup)
      groups.push_back({focals[order[(first + i + 1) / 2]], {order.begin() + long(first), order.begin() + long(i) + 1}});
    first = i + 1;
  }
  size_t grouped = 0;
  for (size_t g = 0; g < groups.size(); ++g) {
    if (g > 0 && groups[g].focal < kApart * groups[g - 1].focal) return {};
    const auto far = std::ranges::count_if(groups[g].members, [&](size_t i) {
      return focals[i] > kWithin * groups[g].focal || kWithin * focals[i] < groups[g].focal;
    });
    if (4 * size_t(far) > groups[g].members.size()) return {};
    grouped += groups[g].members.size();
  }
  if (groups.size() < 2 || double(grouped) < kGroupedShare * double(order.size())) return {};
  for (const size_t i : order) {
    const auto distance = [&](const FocalGroup& g) { return std::abs(std::log(focals[i] / g.focal)); };
    const bool in_one = std::ranges::any_of(groups, [&](const FocalGroup& g) { return std::ranges::count(g.members, i) > 0; });
    if (!in_one) std::ranges::min_element(groups, {}, distance)->members.push_back(i);
  }
  for (FocalGroup& g : groups) std::ranges::sort(g.members);
  return groups;
}

std::string FocalSearch::text() const {
  std::vector<std::string> parts;
  for (const Group& g : groups) parts.push_back(fmt::format("{} photos of {:.0f} px", g.photos, g.focal_px));
  return fmt::format("{}", fmt::join(parts, ", "));
}

FocalSearch cameras_by_focal(Colmap& colmap, const SfmConfig& config, ReconstructDesc& desc, Reconstruction& together) {
  FocalSearch out;
  if (!bundle_supports(together.model) || together.model.images.size() < kFewestMapped) return out;
  OwnFocals own = own_focals(desc, together.model, kSuspicious);
  out.error_before = own.before, out.error_own = own.after;
  if (own.of_photo.empty()) return out;
  const std::vector<Family> families = camera_groups(desc.photos, nullptr);
  std::optional<Reconstruction> best;
  Parted chosen;
  for (int round = 0; round < kMostRounds; ++round) {
    const Parted parts = parted(config, desc, best ? best->model : together.model, families, own.of_photo);
    if (parts.cameras.size() == families.size()) break;
    if (best) join_groups(desc, parts, chosen, best->model);
    if (best && parts.lists() == chosen.lists()) break;
    log_info("sfm: focal lengths of single photos form groups ({:.2f} px instead of {:.2f}): {} cameras are tried", own.after,
             own.before, parts.cameras.size());
    Reconstruction now = mapped_with_cameras(colmap, config, desc, best ? *best : together, parts.cameras,
                                             together.database.parent_path() / fmt::format("focals_{}", round));
    if (now.model.images.size() < (best ? *best : together).model.images.size() || !bundle_supports(now.model)) break;
    best = std::move(now), chosen = parts;
    own = own_focals(desc, best->model, 2);
    if (own.of_photo.empty()) break;
  }
  if (best) {
    out.groups = groups_of(desc, best->model, chosen);
    out.error_after = error_of(best->model);
    if (!out.groups.empty() && out.error_after <= kConfirmed * out.error_before) {
      out.verdict = FocalVerdict::Several;
      for (size_t c = 0; c < chosen.cameras.size(); ++c)
        if (std::ranges::count(chosen.family, chosen.family[c]) > 1)
          for (const size_t i : chosen.cameras[c].photos) {
            desc.photos[i].camera += fmt::format(" focal {}", c);
            desc.photos[i].focal_px.reset();
          }
      together = std::move(*best);
      return out;
    }
  }
  out.groups.clear();
  if (out.error_own <= kContradiction * out.error_before) out.verdict = FocalVerdict::Unsorted;
  return out;
}

void report_focals(const FocalSearch& focals, StageContext& context) {
  switch (focals.verdict) {
    case FocalVerdict::One:
      return;
    case FocalVerdict::Several:
      context.metric("focal_lengths", double(focals.groups.size()));
      log_info("sfm: the photos have several focal lengths, a camera each: {} ({:.2f} px instead of {:.2f} before)",
               focals.text(), focals.error_after, focals.error_before);
      return;
    case FocalVerdict::Unsorted:
      context.warning(
          "SFM_MIXED_FOCAL",
          fmt::format("the photos contradict one focal length: with one for each photo the error falls from {:.2f} to "
                      "{:.2f} px, but no groups of equal ones were found. Poses may be wrong: leave the zoom where it is, "
                      "do not crop, or use the photos with their EXIF data",
                      focals.error_before, focals.error_own));
  }
}

}  // namespace vitrine
