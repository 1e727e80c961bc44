#include "stages/masks/proposed/proposed_source.h"

#include <algorithm>
#include <cmath>

#include "core/base/json.h"
#include "core/base/log.h"
#include "core/base/parallel.h"
#include "core/base/process.h"

namespace vitrine {

namespace {

constexpr float kHullEdge = 1.5f;    // pixels of the small photo: the voxels are no finer
constexpr int kEdgeSide = 640;       // pixels of photos whose edges are looked at
constexpr double kFitShare = 0.8;    // of the work
constexpr float kUnjudged = 0.3f;    // confidence where too few views see the point
constexpr float kBackground = 0.8f;  // of "no": the thresholds let weak reflections go
constexpr float kFoundCase = 0.9f;   // confidence of a case told by its edges
constexpr double kCertainRatio = 3;  // a thing that deviates by this many thresholds is certain
constexpr size_t kFewestPhotos = 8;  // fewer cannot vote

}  // namespace

void describe(Describer& d, ProposedConfig& c) {
  d.group("fit", c.fit, "The diffuse reconstruction whose errors are looked at.");
  d.group("vote", c.vote, "What makes an error a reflection.");
  d.group("display_case", c.display_case, "Display cases, which are told by their edges.");
}

std::shared_ptr<const Proposal> propose(const ProposedConfig& config, const MaskCapture& capture,
                                        const std::function<void(double)>& progress) {
  auto proposal = std::make_shared<Proposal>();
  const std::vector<SmallPhoto> photos = small_photos(capture, config.fit.max_side);
  proposal->things.resize(photos.size());
  proposal->told.resize(photos.size());
  proposal->in_case.resize(photos.size());
  for (size_t v = 0; v < photos.size(); ++v) {
    const Intrinsics& k = photos[v].view.intrinsics;
    proposal->sizes.push_back(k);
    proposal->things[v].assign(size_t(k.width) * size_t(k.height), -1);
    proposal->told[v].assign(proposal->things[v].size(), 0);
  }
  proposal->vote.unsure = photos.size() < kFewestPhotos;
  if (proposal->vote.unsure) return proposal;
  const QuickFit fit = quick_fit(config.fit, capture, photos, [&](double f) { progress(kFitShare * f); });
  proposal->fit_l1 = fit.l1;
  if (config.display_case.look) {
    const std::vector<StandingBox> boxes =
        standing_boxes(edge_photos(capture, kEdgeSide), about_standing_boxes(capture.set), config.display_case.least_posts);
    proposal->cases = display_cases(config.display_case, boxes, photos, fit);
  }
  if (!proposal->cases.empty()) {  // certain; what is less so is not asked
    parallel_for(photos.size(), 1, [&](size_t v) {
      proposal->in_case[v].assign(proposal->told[v].size(), 0);
      for (const DisplayCase& glass : proposal->cases) {
        const std::vector<uint8_t> seen = case_mask(glass, photos[v], fit.views[v]);
        for (size_t i = 0; i < seen.size(); ++i) proposal->in_case[v][i] |= seen[i];
      }
    });
    return proposal;
  }
  const std::vector<DeviationMap> deviations = view_dependence(photos, fit);
  progress(0.5 * (1 + kFitShare));
  proposal->vote = hull_vote(config.vote, capture, photos, fit, deviations);
  parallel_for(photos.size(), 1, [&](size_t v) {
    throw_if_interrupted();
    for (size_t i = 0; i < deviations[v].value.size(); ++i) proposal->told[v][i] = std::isfinite(deviations[v].value[i]);
    if (!proposal->vote.things.empty()) proposal->things[v] = projected_things(proposal->vote, photos[v], fit.views[v]);
  });
  for (const ProposedThing& t : proposal->vote.things)
    log_info("masks: {} thing at ({:.2f} {:.2f} {:.2f}), {:.1f} % of a photo, deviates by {:.3f} (threshold {:.3f})",
             t.transparent ? "a transparent" : "a mirroring", t.centre.x, t.centre.y, t.centre.z, 100 * t.coverage, t.score,
             proposal->vote.weak);
  return proposal;
}

std::optional<SoftMask> ProposedSource::at(size_t view) const {
  const Intrinsics& k = proposal_->sizes[view];
  const size_t pixels = size_t(k.width) * size_t(k.height);
  std::vector<float> mask(pixels, 0.f), sure(pixels, 0.f);
  for (size_t i = 0; i < pixels; ++i) {
    const int t = proposal_->things[view][i];
    if (!proposal_->cases.empty()) {
      mask[i] = proposal_->in_case[view][i];
      sure[i] = kFoundCase;
    } else if (t >= 0 && belongs(proposal_->vote.things[size_t(t)])) {
      const ProposedThing& thing = proposal_->vote.things[size_t(t)];
      mask[i] = 1;
      sure[i] = float(std::clamp(thing.score / (kCertainRatio * proposal_->vote.weak), 0.2, 1.0));
    } else {
      sure[i] = proposal_->told[view][i] ? kBackground : kUnjudged;
    }
  }
  blur_planes(mask, k.width, k.height, kHullEdge);
  SoftMask soft{.value = ImageF(k.width, k.height, 1), .confidence = ImageF(k.width, k.height, 1)};
  std::copy(mask.begin(), mask.end(), soft.value.data().begin());
  std::copy(sure.begin(), sure.end(), soft.confidence.data().begin());
  return soft;
}

void ProposedSource::report(nlohmann::ordered_json& j) const {
  const HullVote& vote = proposal_->vote;
  j["fit_l1"] = proposal_->fit_l1;
  j["deviation"] = {{"typical", vote.typical}, {"weak", vote.weak}, {"strong", vote.strong}};
  j["unsure"] = vote.unsure;
  j["cases"] = nlohmann::ordered_json::array();
  for (const DisplayCase& glass : proposal_->cases) {
    nlohmann::ordered_json corners = nlohmann::ordered_json::array();
    for (size_t i = 0; i < 8; ++i) corners.push_back({glass.box.corner(i).x, glass.box.corner(i).y, glass.box.corner(i).z});
    j["cases"].push_back(
        {{"corners", corners}, {"upright_edges", glass.posts}, {"rim", glass.rim}, {"seen_through", glass.seen_through}});
  }
  j["things"] = nlohmann::ordered_json::array();
  for (const ProposedThing& t : vote.things)
    if (belongs(t))
      j["things"].push_back({{"centre", {t.centre.x, t.centre.y, t.centre.z}},
                             {"voxels", t.voxels},
                             {"deviation", t.score},
                             {"seen_through", t.see_through},
                             {"coverage", t.coverage}});
}

}  // namespace vitrine
