#include "stages/masks/proposed/proposed_source.h"
#include "stages/masks/mask_source.h"
#include "stages/masks/proposed/blank_pixels.h"

#include <algorithm>

#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"

namespace vitrine {

namespace {

constexpr float kHullEdge = 1.5f;                            // pixels of the small photo: voxel resolution
constexpr int kEdgeSide = 640;                               // pixels, photos for edge detection
constexpr double kStereoShare = 0.3, kExplainedShare = 0.5;  // progress after stereo and after the explanation
constexpr float kFound = 0.9f, kDoubted = 0.4f;              // confidence; doubted: a photo and the hull disagree
constexpr size_t kFewestPhotos = 8;                          // minimum for a vote
constexpr double kLeastPosts = 24;  // minimum total edge score of the upright edges of a case above their surroundings

// Where a photo shows nothing, nothing is seen through and nothing is left to explain.
void leave_out_blank(const std::vector<uint8_t>& blank, DepthMap& map, Explanation& explained) {
  for (size_t i = 0; i < blank.size(); ++i) {
    if (!blank[i]) continue;
    if (i < map.trusted.size()) map.trusted[i] = 0;
    if (i < explained.error.size()) explained.error[i] = explained.around[i] = 0;
  }
}

}  // namespace

void describe(Describer& d, DisplayCaseConfig& c) {
  d.option("look", c.look, "Look for display cases: boxes of glass that stand upright.");
}

void describe(Describer& d, ProposedConfig& c) {
  d.group("display_case", c.display_case, "Display cases, which are found by their edges.");
}

std::shared_ptr<const Proposal> propose(const ProposedConfig& config, const MaskCapture& capture,
                                        const std::function<void(double)>& progress) {
  auto proposal = std::make_shared<Proposal>();
  const std::vector<View> views = small_views(capture, kSmallSide);
  for (const View& view : views) {
    proposal->sizes.push_back(view.intrinsics);
    const size_t pixels = view.intrinsics.pixel_count();
    for (auto* planes : {&proposal->in_case, &proposal->mirrored, &proposal->doubted}) planes->emplace_back(pixels, uint8_t(0));
  }
  proposal->unsure = views.size() < kFewestPhotos;
  if (proposal->unsure) return proposal;
  const std::vector<SmallPhoto> photos = small_photos(capture, kSmallSide);
  const SmallStereo stereo(edge_photos(photos), capture.set);
  proposal->unsure = stereo.blind();
  if (proposal->unsure) return proposal;
  progress(kStereoShare);
  const Surroundings scene = stereo.surroundings();
  std::vector<Explanation> explained(views.size());
  parallel_for(views.size(), 1, [&](size_t v) {
    if (interrupt_signal() == 0) explained[v] = explanation(scene, v);
  });
  throw_if_interrupted();
  std::vector<DepthMap> maps(scene.maps.begin(), scene.maps.end());
  if (capture.cut_out)
    for (const SmallPhoto& photo : photos) {
      const size_t v = proposal->blank.size();
      proposal->blank.push_back(blank_pixels(photo));
      leave_out_blank(proposal->blank[v], maps[v], explained[v]);
    }
  progress(kExplainedShare);
  if (config.display_case.look)
    proposal->cases = display_cases(
        standing_boxes(edge_photos(capture, kEdgeSide), about_standing_boxes(capture.set), kLeastPosts), views, maps);
  for (const DisplayCase& glass : proposal->cases)
    parallel_for(views.size(), 1, [&](size_t v) {
      const std::vector<uint8_t> seen = case_mask(glass, views[v], maps[v]);
      for (size_t i = 0; i < seen.size(); ++i) proposal->in_case[v][i] |= seen[i];
    });
  if (capture.camera_flash) {
    log_info(
        "masks: the photos were taken with the camera's flash, which changes every surface with the view: mirrors are not looked "
        "for");
    return proposal;
  }
  proposal->mirrors = found_mirrors({.capture = capture, .views = views, .photos = photos, .stereo = &stereo}, explained,
                                    [&](double f) { progress(kExplainedShare + (1 - kExplainedShare) * f); });
  for (const FoundMirror& mirror : proposal->mirrors) {
    log_info(
        "masks: a mirror {:.2f} across, found by how it changes with the view (masks/contact_sheet.png shows it; if it is none, "
        "role: opaque in objects/objects.json and --objects take it out)",
        mirror.object.summary.edge);
    for (size_t v = 0; v < views.size(); ++v)
      for (size_t i = 0; i < mirror.object.inside[v].size(); ++i) {
        proposal->mirrored[v][i] |= mirror.object.inside[v][i];
        proposal->doubted[v][i] |= mirror.object.doubted[v][i];
      }
  }
  return proposal;
}

std::optional<SoftMask> ProposedSource::at(size_t view) const {
  const Intrinsics& k = proposal_->sizes[view];
  const std::vector<uint8_t>&glass = proposal_->in_case[view], &mirrors = proposal_->mirrored[view];
  std::vector<float> mask(glass.begin(), glass.end());
  SoftMask soft{.value = ImageF(k.width, k.height, 1), .confidence = ImageF(k.width, k.height, 1)};
  std::ranges::fill(soft.confidence.data(), kFound);
  if (kind_ == MaskClass::Specular)
    for (size_t i = 0; i < mask.size(); ++i) {
      if (mirrors[i]) mask[i] = 1;
      if (proposal_->doubted[view][i]) soft.confidence.data()[i] = kDoubted;
    }
  blur_planes(mask, k.width, k.height, kHullEdge);
  if (!proposal_->blank.empty())
    for (size_t i = 0; i < mask.size(); ++i)
      if (proposal_->blank[view][i]) mask[i] = 0;
  std::ranges::copy(mask, soft.value.data().begin());
  return soft;
}

void ProposedSource::report(nlohmann::ordered_json& j) const {
  j["unsure"] = proposal_->unsure;
  j["cases"] = nlohmann::ordered_json::array();
  for (const DisplayCase& glass : proposal_->cases) {
    nlohmann::ordered_json corners = nlohmann::ordered_json::array();
    for (size_t i = 0; i < 8; ++i) corners.push_back({glass.box.corner(i).x, glass.box.corner(i).y, glass.box.corner(i).z});
    j["cases"].push_back(
        {{"corners", corners}, {"upright_edges", glass.posts}, {"rim", glass.rim}, {"seen_through", glass.seen_through}});
  }
  if (kind_ != MaskClass::Specular) return;
  j["mirrors"] = nlohmann::ordered_json::array();
  for (const FoundMirror& mirror : proposal_->mirrors)
    j["mirrors"].push_back({{"across", mirror.object.summary.edge},
                            {"hull_changes", mirror.of_hull},
                            {"stereo_changes", mirror.of_stereo},
                            {"stereo_share", mirror.stereo_share}});
}

}  // namespace vitrine
