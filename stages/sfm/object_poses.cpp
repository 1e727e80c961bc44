#include "stages/sfm/object_poses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/quantile.h"
#include "core/intake/poses/colmap_repair.h"
#include "core/scene/camera/projection.h"
#include "stages/sfm/normalize.h"
#include "stages/sfm/point_filter.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

namespace {

constexpr double kSameDirection = 0.966;                    // cosine of 15 degrees
constexpr double kSameDistance = 1.4;                       // ratio
constexpr size_t kFewestCameras = 2;                        // on each side
constexpr size_t kNeighbourhood = 16;                       // points
constexpr double kFreely = 0.3;                             // of the tracks around a point that cross the split in name order
constexpr size_t kFewestMoved = 100, kFewestStanding = 50;  // points
constexpr double kLeastMoved = 0.1;                         // of the points viewed by cameras of both sides
constexpr double kStepOfMatches = 2.0 / 3;                  // of the viewing angle that contains 90 % of the matching pairs

// Per point, the photos in name order: those that see it, and those with a similar viewing direction and distance.
struct Visibility {
  std::vector<std::vector<uint8_t>> sees, looks;  // [point][photo]
};

Visibility visibility_of(const ColmapModel& model) {
  const size_t photos = model.images.size();
  std::vector<View> views;  // without distortion, whose effect is below a tenth of the picture
  std::vector<Vec3d> centres;
  std::map<uint32_t, size_t> index;
  for (const ColmapImage& image : model.images) {
    index[image.id] = views.size();
    View& view = views.emplace_back();
    view.cam_from_world = image.cam_from_world();
    view.intrinsics = pinhole_part(*model.find_camera(image.camera_id));
    centres.push_back(view.centre_in_world());
  }
  Visibility v;
  v.sees.resize(model.points.size()), v.looks.resize(model.points.size());
  parallel_for(model.points.size(), 64, [&](size_t i) {
    const ColmapPoint3D& point = model.points[i];
    std::vector<uint8_t>&sees = v.sees[i], &looks = v.looks[i];
    sees.assign(photos, 0);
    for (const ColmapTrackElement& t : point.track) sees[index.at(t.image_id)] = 1;
    looks = sees;
    for (size_t p = 0; p < photos; ++p) {
      if (sees[p]) continue;
      if (!image_point(point.position, views[p])) continue;
      const Vec3d to = point.position - centres[p];
      for (size_t seen = 0; seen < photos && !looks[p]; ++seen) {
        if (!sees[seen]) continue;
        const Vec3d other = point.position - centres[seen];
        const double a = length(to), b = length(other);
        looks[p] = dot(to, other) > kSameDirection * a * b && a < kSameDistance * b && b < kSameDistance * a;
      }
    }
  });
  return v;
}

// Finds, without object masks, the points of a region that was moved between the photos before and after some split in name
// order.
//
// Cameras before and after the split view a point from nearly the same direction. Static points are matched on both sides: their
// tracks cross the split. A moved region looks different from the same direction: none of its tracks cross the split. Selects the
// split with most points surrounded by such points; the tracks of all other points in view must cross it freely. Returns
// [model.points] 1: in the moved region; empty: nothing moved.
std::vector<uint8_t> moved_region(const ColmapModel& model) {
  const size_t photos = model.images.size(), points = model.points.size();
  if (photos < 2 * kSmallestPass || points < kFewestMoved + kFewestStanding) return {};
  const Visibility visibility = visibility_of(model);
  std::vector<Vec3d> positions;
  for (const ColmapPoint3D& p : model.points) positions.push_back(p.position);
  const std::vector<std::vector<uint32_t>> around = neighbours(positions, kNeighbourhood);
  std::vector<uint8_t> best;
  size_t most = 0;
  for (size_t place = kSmallestPass; place + kSmallestPass <= photos; ++place) {
    std::vector<uint8_t> looked_at(points), spans(points), moved(points, 0);
    for (size_t i = 0; i < points; ++i) {
      const auto count = [&](const std::vector<uint8_t>& of, size_t from, size_t to) {
        return size_t(std::count(of.begin() + long(from), of.begin() + long(to), 1));
      };
      looked_at[i] = std::min(count(visibility.looks[i], 0, place), count(visibility.looks[i], place, photos)) >= kFewestCameras;
      spans[i] = std::min(count(visibility.sees[i], 0, place), count(visibility.sees[i], place, photos)) > 0;
    }
    size_t all = 0, gone = 0, standing = 0;
    for (size_t i = 0; i < points; ++i) {
      if (!looked_at[i]) continue;
      size_t of = 1, spanning = spans[i];
      for (uint32_t n : around[i]) of += looked_at[n], spanning += looked_at[n] && spans[n];
      ++all;
      if (of > kNeighbourhood / 2 && spanning == 0)
        moved[i] = 1, ++gone;
      else if (double(spanning) > kFreely * double(of))
        ++standing;
    }
    if (gone <= most || gone < kFewestMoved || double(gone) < kLeastMoved * double(all) || standing < kFewestStanding) continue;
    most = gone;
    best = std::move(moved);
  }
  return best;
}

size_t passes_in(const Passes& passes, const ColmapModel& model) {
  return size_t(std::count_if(passes.begin(), passes.end(), [&](const std::vector<std::string>& photos) {
    const auto posed = std::count_if(model.images.begin(), model.images.end(), [&](const ColmapImage& image) {
      return std::find(photos.begin(), photos.end(), image.name) != photos.end();
    });
    return size_t(posed) >= kSmallestPass;
  }));
}

// [photo] index of its pass. Photos of no pass take that of the previous photo in name order.
std::vector<size_t> pass_of_each(std::span<const SfmPhoto> photos, const Passes& passes) {
  std::vector<size_t> of(photos.size(), 0);
  for (size_t i = 0; i < photos.size(); ++i) {
    of[i] = pass_of(passes, photos[i].name);
    if (of[i] == passes.size()) of[i] = i > 0 ? of[i - 1] : 0;
  }
  return of;
}

// The passes, completed by the photos of the model that are in no pass.
Passes completed(const Passes& passes, std::span<const SfmPhoto> photos, const ColmapModel& model) {
  const std::vector<size_t> of = pass_of_each(photos, passes);
  Passes all(passes.size());
  for (size_t i = 0; i < photos.size(); ++i)
    if (std::any_of(model.images.begin(), model.images.end(), [&](const ColmapImage& m) { return m.name == photos[i].name; }))
      all[of[i]].push_back(photos[i].name);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return all;
}

// Description of another reconstruction of the same photos; the progress bar stays at the end of the first.
ReconstructDesc further(const ReconstructDesc& desc, const char* folder, UsedFeatures used) {
  ReconstructDesc out = desc;
  out.work_folder = desc.work_folder / folder;
  out.used = used;
  if (desc.progress) out.progress = [report = desc.progress](double, const std::string& text) { report(1, text); };
  return out;
}

Reconstruction joined_passes(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const Passes& passes) {
  ReconstructDesc joined = further(desc, "passes", UsedFeatures::All);
  joined.pass_of = pass_of_each(desc.photos, passes);
  return reconstruct(colmap, config, joined);
}

std::vector<ColmapModel> models_of_surroundings(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc,
                                                const Reconstruction& together) {
  ReconstructDesc around = further(desc, "surroundings", UsedFeatures::Surroundings);
  around.found_features = together.database;
  Reconstruction r = reconstruct(colmap, config, around);
  std::vector<ColmapModel> models = std::move(r.smaller_models);
  models.insert(models.begin(), std::move(r.model));
  return models;
}

// Estimated number of photos needed between the lowest cameras of two passes, in steps that still match (`furthest_match`),
// assuming that the object was turned upside down.
size_t photos_between(const ColmapModel& model, const Vec3d& up, double furthest_match) {
  std::vector<double> elevations;
  for (const ColmapImage& image : model.images)
    elevations.push_back(
        std::asin(std::clamp(-dot(transposed_times(image.cam_from_world().rotation, Vec3d{0, 0, 1}), up), -1.0, 1.0)));
  const double lowest = quantile_of(elevations, 0.1) * 180 / std::numbers::pi;
  return size_t(std::clamp(std::ceil(2 * lowest / std::max(kStepOfMatches * furthest_match, 5.0)) - 1, 1.0, 20.0));
}

}  // namespace

ObjectPasses poses_of_object(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const FeatureMasks& masks,
                             Reconstruction& together) {
  const FoundMatches matches = found_matches(desc.photos, together.database, MatchKind::Descriptors);
  std::vector<std::vector<uint8_t>> on_object(desc.photos.size());
  for (size_t i = 0; i < on_object.size(); ++i) on_object[i] = masks.on_object(i, matches.xy[i]);
  const MotionEvidence evidence = motion_evidence(together.model, matches, on_object);
  // Poses may follow the object in some photos and its surroundings in others: a model of the surroundings alone detects that.
  const std::vector<ColmapModel> surroundings = models_of_surroundings(colmap, config, desc, together);
  ObjectPasses out{.passes = evidence.passes.empty() ? passes_by_motion(together.model, surroundings) : evidence.passes,
                   .contradicting = evidence.pairs,
                   .furthest_match = evidence.furthest_match};
  // One model of the surroundings must contain several passes; otherwise there is no evidence that the object moved.
  const bool surrounded = std::any_of(surroundings.begin(), surroundings.end(),
                                      [&](const ColmapModel& model) { return passes_in(out.passes, model) > 1; });
  if (out.passes.empty() || !surrounded || turns_in_most_photos(together.model, surroundings)) return {};
  log_info("sfm: the object moves against what surrounds it: {} are joined by its features", passes_text(out.passes));
  Reconstruction joined = joined_passes(colmap, config, desc, out.passes);
  if (passes_in(out.passes, joined.model) < 2) {
    out.poses = PosesOf::LargestPass;
    together.model = restricted(together.model, out.passes[0]);
    for (PhotoReport& p : together.photos) {
      p.other_pass = pass_of(out.passes, p.name) != 0;
      p.registered = p.registered && !p.other_pass;
    }
    return out;
  }
  // The joined poses follow the object in all photos: recompute the passes from them.
  Passes passes = passes_by_motion(joined.model, surroundings);
  if (passes.empty()) {
    log_info("sfm: the object stands still with its surroundings after all");
    return {};
  }
  passes = completed(passes, desc.photos, joined.model);
  if (passes != out.passes) {
    out.passes = std::move(passes);
    log_info("sfm: {} are joined by the features of the object", passes_text(out.passes));
    joined = joined_passes(colmap, config, desc, out.passes);
  }
  together = std::move(joined);
  return out;
}

ObjectPasses passes_without_masks(const ReconstructDesc& desc, const Reconstruction& together) {
  const std::vector<uint8_t> moved = moved_region(together.model);
  if (moved.empty()) return {};
  const FoundMatches matches = found_matches(desc.photos, together.database, MatchKind::Descriptors);
  // Features of the moved region. The model stores them by pixel position.
  std::vector<std::vector<uint8_t>> on_object(desc.photos.size());
  for (size_t i = 0; i < on_object.size(); ++i) {
    on_object[i].assign(matches.xy[i].size() / 2, 0);
    const auto image = std::find_if(together.model.images.begin(), together.model.images.end(),
                                    [&](const ColmapImage& m) { return m.name == desc.photos[i].name; });
    if (image == together.model.images.end()) continue;
    std::set<std::pair<float, float>> places;
    for (const ColmapPoint2D& p : image->points)
      if (const ColmapPoint3D* point = p.point3d_id == kNoPoint3D ? nullptr : together.model.find_point(p.point3d_id))
        if (moved[size_t(point - together.model.points.data())]) places.insert({float(p.x), float(p.y)});
    for (size_t f = 0; f < on_object[i].size(); ++f)
      on_object[i][f] = places.contains({matches.xy[i][2 * f], matches.xy[i][2 * f + 1]});
  }
  const MotionEvidence evidence = motion_evidence(together.model, matches, on_object);
  if (evidence.passes.size() < 2) return {};
  return {.passes = evidence.passes,
          .poses = PosesOf::Surroundings,
          .contradicting = evidence.pairs,
          .furthest_match = evidence.furthest_match};
}

ColmapModel object_points(const ColmapModel& model, std::span<const SfmPhoto> photos, const FeatureMasks& masks) {
  std::vector<size_t> inside(model.points.size(), 0);
  for (const ColmapImage& image : model.images) {
    const auto photo = std::find_if(photos.begin(), photos.end(), [&](const SfmPhoto& p) { return p.name == image.name; });
    std::vector<float> xy;
    for (const ColmapPoint2D& p : image.points) xy.push_back(float(p.x)), xy.push_back(float(p.y));
    const std::vector<uint8_t> on_object = masks.on_object(size_t(photo - photos.begin()), xy);
    for (size_t i = 0; i < on_object.size(); ++i)
      if (on_object[i] && image.points[i].point3d_id != kNoPoint3D)
        ++inside[size_t(model.find_point(image.points[i].point3d_id) - model.points.data())];
  }
  return compacted(model, [&](const ColmapPoint3D& p) {
    return 2 * inside[size_t(model.find_point(p.id) - model.points.data())] > p.track.size();
  });
}

void report_passes(const ObjectPasses& passes, const ColmapModel& model, UpMethod up, StageContext& context) {
  context.metric("passes", double(std::max<size_t>(passes.passes.size(), 1)));
  if (passes.passes.empty()) return;
  make_folders(context.output() / "sfm");
  write_passes(context.output(), passes.passes, passes.poses);
  switch (passes.poses) {
    case PosesOf::Object:
      log_info(
          "sfm: {}: the object was moved between them, its own features join them; what surrounds it is no part of the scene",
          passes_text(passes.passes));
      return;
    case PosesOf::LargestPass:
      context.warning(
          "SFM_PASSES_NOT_JOINED",
          fmt::format("{} that share too little of the object: the largest pass is reconstructed. About {} photos are "
                      "missing in between: from lower down, or of the object on its side, in steps of {:.0f} degrees",
                      passes_text(passes.passes), photos_between(model, scene_up(model, up).up, passes.furthest_match),
                      kStepOfMatches * passes.furthest_match));
      return;
    case PosesOf::Surroundings:
      context.warning(
          "SFM_OBJECT_TURNED",
          fmt::format("{}: something that they show was moved between them against the rest, and no poses fit both; it "
                      "will stand in the scene more than once. Masks of the object let its own features decide: a folder "
                      "with one for each photo (--masks DIR, DIR/object)",
                      passes_text(passes.passes)));
  }
}

}  // namespace vitrine
