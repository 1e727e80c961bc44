// The box whose silhouettes are the masks: display cases, aquaria and blocks are boxes, and their masks say so better than any
// hull that is carved by them, which bulges between the cones of few photos. Nine numbers (three angles, six faces) against the
// silhouettes of all photos: faces come out right to a fraction of a pixel.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/shape/box.h"
#include "core/stereo/mask_rows.h"
#include "core/stereo/silhouette.h"

namespace vitrine {

// Measured: cases with true masks .97 and more, a jar .89, a ball .86.
inline constexpr double kLeastBoxAgreement = 0.94;

struct BoxFit {
  Box box;
  double agreement = 0;  // intersection over union of silhouettes and masks: mean over the better three quarters of the photos
};

// Empty unless the silhouettes agree to `least`: a bottle, a vase, a ball is no box. `about`: what the box is looked for around,
// the bounds of a hull; z is where one of its edges starts to point. What the photos do not say (mask < 0) does not count; a
// photo with something in front of the box is outvoted.
std::optional<BoxFit> fit_box(std::span<const Silhouette> masks, const Bounds3& about, double least = kLeastBoxAgreement);

// What `fit_box` makes as large as it can.
double agreement(std::span<const Silhouette> masks, const Box& box);

// Its silhouette; empty if a corner is behind the camera.
RowSpans spans_of_box(const Box& box, const View& view);

// 1 inside the silhouette of the box, [h,w] of the view.
std::vector<uint8_t> silhouette_mask(const Box& box, const View& view);

}  // namespace vitrine
