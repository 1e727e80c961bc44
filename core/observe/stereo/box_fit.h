// Fits an oriented box to masks: display cases, aquaria, blocks. A visual hull carved from few photos bulges between the viewing
// cones; the nine parameters of a box (three angles, six faces) fitted to all silhouettes place its faces to a fraction of a
// pixel.
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

// Measured IoU: display cases with true masks .97 and more, a jar .89, a ball .86.
inline constexpr double kLeastBoxAgreement = 0.94;

struct BoxFit {
  Box box;
  double agreement = 0;  // IoU of silhouettes and masks: mean over the best three quarters of the photos
};

// nullopt if the IoU stays below `least` (bottle, vase, ball). `about`: initial bounds, such as those of a visual hull; one
// edge starts along z. Unknown pixels (mask < 0) do not count. Photos in which another object occludes the box are outliers.
std::optional<BoxFit> fit_box(std::span<const Silhouette> masks, const Bounds3& about, double least = kLeastBoxAgreement);

// The score that `fit_box` maximises.
double agreement(std::span<const Silhouette> masks, const Box& box);

// Silhouette of the box; empty if a corner is behind the camera.
RowSpans spans_of_box(const Box& box, const View& view);

// 1 inside the silhouette of the box, [h,w] of the view.
std::vector<uint8_t> silhouette_mask(const Box& box, const View& view);

// Rotation about a coordinate axis, radians.
Mat3d turned(size_t axis, double angle);
// Moves face `i` (low and high of each axis) outwards by `step` of the diagonal, or, for i = 6 to 8, rotates the box about its
// centre by `step` radians.
Box moved(const Box& box, size_t i, double step);

inline constexpr std::array<size_t, 9> kBoxNumbers{0, 1, 2, 3, 4, 5, 6, 7, 8};  // parameter indices of moved()

// Pattern search that maximises score(box). Returns the best score.
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
