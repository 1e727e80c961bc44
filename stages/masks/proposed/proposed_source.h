// Masks without user input: display cases and mirrors detected in the photos (README, "proposed").
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/foundation/config/describe.h"
#include "core/observe/stereo/patch_match.h"
#include "core/observe/stereo/upright_edges.h"
#include "core/scene/camera/view_set.h"
#include "stages/masks/boxes/carried_object.h"

namespace vitrine {

// Detection of unmarked display cases: upright boxes with visible edges (core/observe/stereo/upright_edges.h) and transparent
// sides. A crate has such edges as well, but there stereo reconstructs the sides; with glass it reconstructs the content or the
// background.

struct DisplayCase {
  Box box;                    // its bottom is at the height of the supporting surface
  double posts = 0, rim = 0;  // StandingBox
  double seen_through = 0;    // share of the known pixels whose surface lies behind a side; minimum over the sides
};

// Search region: the volume that the cameras surround. Empty without sparse points.
Bounds3 about_standing_boxes(const ViewSet& set);
// The boxes (best first) that are glass; none inside another. `maps`: one per view, of its size.
std::vector<DisplayCase> display_cases(std::span<const StandingBox> boxes, std::span<const View> views,
                                       std::span<const DepthMap> maps);

// [h,w] of the view: 1 where the case is visible and not occluded by a known surface.
std::vector<uint8_t> case_mask(const DisplayCase& glass, const View& view, const DepthMap& map);

// Detection of unmarked mirrors. A piece that neither stereo nor a large plane explains
// (core/observe/stereo/unexplained_pieces.h) is propagated to all photos like an object marked with boxes. It is a mirror if both
// kinds of its surface points are as view-dependent as the photos vary (core/observe/stereo/view_dependence.h): those of the hull
// (an untextured surface has one colour from all sides) and those that stereo found on it (texture stays in place). The light
// must not move with the camera: the flash of a camera makes matt surfaces view-dependent.

struct FoundMirror {
  CarriedObject object;
  double of_hull = 0, of_stereo = 0;  // view dependence
  double stereo_share = 0;            // share of its pixels at which stereo found a surface of its own
};

// Requires `desc.stereo`. Largest first; none inside another.
std::vector<FoundMirror> found_mirrors(const CarryDesc& desc, std::span<const Explanation> explained,
                                       const std::function<void(double)>& progress);

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
  std::vector<std::vector<uint8_t>> blank;  // [view][h,w] of photos without background (blank_pixels.h); empty: none
  bool unsure = false;                      // too few photos, or too little stereo
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
