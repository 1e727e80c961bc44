// Masks that nobody drew: what differs from view to view after a short diffuse fit (README, "proposed").
#pragma once

#include <functional>
#include <memory>

#include "stages/masks/proposed/display_case.h"
#include "stages/masks/proposed/hull_vote.h"

namespace vitrine {

struct ProposedConfig {
  QuickFitConfig fit;
  HullVoteConfig vote;
  DisplayCaseConfig display_case;
};
void describe(Describer& d, ProposedConfig& c);

// One analysis serves all classes.
struct Proposal {
  std::vector<std::vector<int>> things;    // [view][h,w] which thing is seen there, or -1
  std::vector<std::vector<uint8_t>> told;  // [view][h,w] enough views saw the point to judge it
  std::vector<Intrinsics> sizes;           // [view]
  std::vector<DisplayCase> cases;          // where there is one, nothing is voted on
  HullVote vote;
  std::vector<std::vector<uint8_t>> in_case;  // [view][h,w] the glass of one of them is seen there
  double fit_l1 = 0;
};
std::shared_ptr<const Proposal> propose(const ProposedConfig& config, const MaskCapture& capture,
                                        const std::function<void(double)>& progress);

class ProposedSource final : public MaskSource {
 public:
  // `kind`: transparent (what one sees through) or specular (all that changes with the view; glass mirrors, too).
  ProposedSource(std::shared_ptr<const Proposal> proposal, MaskClass kind) : proposal_(std::move(proposal)), kind_(kind) {}
  std::string_view name() const override { return "proposed"; }
  std::optional<SoftMask> at(size_t view) const override;
  // Boxes that stand on their edges explain the photos.
  std::string_view trust() const override { return proposal_->cases.empty() ? "guessed" : "detected"; }
  bool propagated() const override { return true; }
  void report(nlohmann::ordered_json& j) const override;

 private:
  bool belongs(const ProposedThing& thing) const { return kind_ == MaskClass::Specular || thing.transparent; }
  std::shared_ptr<const Proposal> proposal_;
  MaskClass kind_;
};

}  // namespace vitrine
