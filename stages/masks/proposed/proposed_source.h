// Masks without user input: display cases and mirrors detected in the photos (README, "proposed").
#pragma once

#include <functional>
#include <memory>

#include "core/foundation/config/describe.h"
#include "stages/masks/proposed/display_case.h"
#include "stages/masks/proposed/found_mirrors.h"

namespace vitrine {

struct DisplayCaseConfig {
  bool look = true;
};
struct ProposedConfig {
  DisplayCaseConfig display_case;
};
void describe(Describer& d, DisplayCaseConfig& c);
void describe(Describer& d, ProposedConfig& c);

// Result of one analysis, used for both classes.
struct Proposal {
  std::vector<Intrinsics> sizes;  // [view]
  std::vector<DisplayCase> cases;
  std::vector<FoundMirror> mirrors;
  std::vector<std::vector<uint8_t>> in_case, mirrored, doubted;  // [view][h,w]
  bool unsure = false;                                           // too few photos, or too little stereo
};
std::shared_ptr<const Proposal> propose(const ProposedConfig& config, const MaskCapture& capture,
                                        const std::function<void(double)>& progress);

class ProposedSource final : public MaskSource {
 public:
  // `kind`: transparent (cases) or specular (cases and mirrors).
  ProposedSource(std::shared_ptr<const Proposal> proposal, MaskClass kind) : proposal_(std::move(proposal)), kind_(kind) {}
  std::string_view name() const override { return "proposed"; }
  std::optional<SoftMask> at(size_t view) const override;
  std::string_view trust() const override { return "detected"; }
  bool propagated() const override { return true; }
  void report(nlohmann::ordered_json& j) const override;

 private:
  std::shared_ptr<const Proposal> proposal_;
  MaskClass kind_;
};

}  // namespace vitrine
