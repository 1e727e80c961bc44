// The box whose silhouettes are the masks: display cases, aquaria and blocks are boxes, and their masks say so better than any
// hull that is carved by them, which bulges between the cones of few photos. Nine numbers (three angles, six faces) against the
// silhouettes of all photos: faces come out right to a fraction of a pixel.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/pattern_search.h"
#include "core/scene/shape/box.h"
#include "core/observe/stereo/mask_rows.h"
#include "core/observe/stereo/silhouette.h"

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

// Pattern search over the numbers of a box: six faces and three angles.
// About one of the axes, radians.
Mat3d turned(size_t axis, double angle);
// Moves face `i` (low and high of each axis) outwards by `step` of the diagonal, or, for i = 6 to 8, turns the box about its
// middle by `step` radians.
Box moved(const Box& box, size_t i, double step);

inline constexpr std::array<size_t, 9> kBoxNumbers{0, 1, 2, 3, 4, 5, 6, 7, 8};  // as moved() counts them

// Raises score(box), and returns what it was raised to.
template <class Score>
double improve(const Score& score, double step, double last_step, Box& box, std::span<const size_t> numbers = kBoxNumbers) {
  const auto move = [](const Box& from, size_t i, double by) -> std::optional<Box> {
    const Box trial = moved(from, i, by);
    if (!(trial.high.x > trial.low.x && trial.high.y > trial.low.y && trial.high.z > trial.low.z)) return std::nullopt;
    return trial;
  };
  return pattern_search(score, move, {step, last_step}, numbers, box);
}

}  // namespace vitrine
