#include "stages/sfm/object_poses.h"

#include <algorithm>
#include <set>

#include "core/base/log.h"
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

}  // namespace

ObjectPasses poses_of_object(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const FeatureMasks& masks,
                             Reconstruction& together) {
  const FoundMatches matches = found_matches(desc.photos, together.database, MatchKind::Descriptors);
  std::vector<std::vector<uint8_t>> on_object(desc.photos.size());
  for (size_t i = 0; i < on_object.size(); ++i) {
    on_object[i] = masks.classes_at(i, matches.xy[i]);
    for (uint8_t& c : on_object[i]) c = (c >> unsigned(MaskClass::Object)) & 1;
  }
  const MotionEvidence evidence = motion_evidence(together.model, matches, on_object);
  if (evidence.passes.size() < 2) return {};
  log_info("sfm: {} pairs of photos contradict each other about the object and what surrounds it: its features find the poses",
           evidence.pairs);
  ReconstructDesc alone = desc;
  alone.work_folder = desc.work_folder / "object";
  alone.used = UsedFeatures::Object;
  Reconstruction object = reconstruct(colmap, config, alone);
  ObjectPasses out{.passes = evidence.passes, .contradicting = evidence.pairs, .furthest_match = evidence.furthest_match};
  if (passes_in(out.passes, object.model) > 1) {
    if (!moved_between(out.passes, object.model, together.model)) {
      log_info("sfm: the object stands still with its surroundings after all");
      return {};
    }
    together = std::move(object);
    return out;
  }
  out.poses = PosesOf::LargestPass;
  together.model = restricted(together.model, out.passes[0]);
  for (PhotoReport& p : together.photos) {
    p.other_pass = std::find(out.passes[0].begin(), out.passes[0].end(), p.name) == out.passes[0].end();
    p.registered = p.registered && !p.other_pass;
  }
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

}  // namespace vitrine
