#include "stages/sfm/object_poses.h"

#include <algorithm>
#include <set>

#include "core/base/log.h"
#include "core/camera/compacted.h"
#include "stages/sfm/moved_region.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

namespace {

size_t passes_in(const Passes& passes, const ColmapModel& model) {
  return size_t(std::count_if(passes.begin(), passes.end(), [&](const std::vector<std::string>& photos) {
    const auto posed = std::count_if(model.images.begin(), model.images.end(), [&](const ColmapImage& image) {
      return std::find(photos.begin(), photos.end(), image.name) != photos.end();
    });
    return size_t(posed) >= kSmallestPass;
  }));
}

// [photo] Photos of no pass have that of the photo before them in name order.
std::vector<size_t> pass_of_each(std::span<const SfmPhoto> photos, const Passes& passes) {
  std::vector<size_t> of(photos.size(), 0);
  for (size_t i = 0; i < photos.size(); ++i) {
    of[i] = pass_of(passes, photos[i].name);
    if (of[i] == passes.size()) of[i] = i > 0 ? of[i - 1] : 0;
  }
  return of;
}

// With the photos of the model that no pass has.
Passes completed(const Passes& passes, std::span<const SfmPhoto> photos, const ColmapModel& model) {
  const std::vector<size_t> of = pass_of_each(photos, passes);
  Passes all(passes.size());
  for (size_t i = 0; i < photos.size(); ++i)
    if (std::any_of(model.images.begin(), model.images.end(), [&](const ColmapImage& m) { return m.name == photos[i].name; }))
      all[of[i]].push_back(photos[i].name);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return all;
}

// The description of a further reconstruction of the same photos; the progress stays at the end of the first.
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

}  // namespace

ObjectPasses poses_of_object(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const FeatureMasks& masks,
                             Reconstruction& together) {
  const FoundMatches matches = found_matches(desc.photos, together.database, MatchKind::Descriptors);
  std::vector<std::vector<uint8_t>> on_object(desc.photos.size());
  for (size_t i = 0; i < on_object.size(); ++i) on_object[i] = masks.on_object(i, matches.xy[i]);
  const MotionEvidence evidence = motion_evidence(together.model, matches, on_object);
  // Poses may follow the object in some photos and its surroundings in others: then the surroundings by themselves show it.
  const std::vector<ColmapModel> surroundings = models_of_surroundings(colmap, config, desc, together);
  ObjectPasses out{.passes = evidence.passes.empty() ? passes_by_motion(together.model, surroundings) : evidence.passes,
                   .contradicting = evidence.pairs,
                   .furthest_match = evidence.furthest_match};
  // What surrounds the object has to be one thing in several passes; else it proves nothing against the object.
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
  // Its poses follow the object in all photos: now the passes are known well.
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
  // The features that show the region. The model has them by their place in the picture.
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

}  // namespace vitrine
