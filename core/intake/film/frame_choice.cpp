#include "core/intake/film/frame_choice.h"

#include <algorithm>

#include "core/foundation/math/median.h"

namespace vitrine {

namespace {

constexpr double kLeastMotion = 0.03;
constexpr double kSoft = 0.35;     // of the median sharpness of its neighbours
constexpr size_t kNeighbours = 5;  // chosen frames on either side

// A stretch begins with the first frame that is `gap` away from the last chosen one, and is `gap` long.
void choose_from(const std::vector<TrackedFrame>& frames, size_t film, double gap, std::vector<ChosenFrame>& out) {
  for (size_t i = 0; i < frames.size();) {
    const double end = frames[i].motion + gap;
    if (i > 0 && frames.back().motion < end) break;  // too short to hold a sharp frame for sure
    size_t best = i, k = i;
    for (; k < frames.size() && frames[k].motion < end; ++k)
      if (frames[k].sharpness > frames[best].sharpness) best = k;
    out.push_back({film, best, std::max<size_t>(k - i, 1)});
    const double next = frames[best].motion + gap;
    while (i < frames.size() && frames[i].motion < next) ++i;
  }
}

std::vector<ChosenFrame> chosen_with(std::span<const std::vector<TrackedFrame>> films, double gap) {
  std::vector<ChosenFrame> out;
  for (size_t f = 0; f < films.size(); ++f) choose_from(films[f], f, gap, out);
  return out;
}

}  // namespace

FrameChoice choose_frames(std::span<const std::vector<TrackedFrame>> films, size_t most) {
  double low = kLeastMotion, high = low;
  std::vector<ChosenFrame> all = chosen_with(films, low);
  if (all.size() > most) {
    while (all.size() > std::max(most, films.size()) && high < 1e6) all = chosen_with(films, high *= 2);
    constexpr int kHalvings = 30;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (chosen_with(films, middle).size() > std::max(most, films.size()) ? low : high) = middle;
    }
    all = chosen_with(films, high);
  }
  FrameChoice choice{.frames = {}, .least_motion = high, .soft = std::vector<size_t>(films.size())};
  const auto sharpness = [&](const ChosenFrame& c) { return films[c.film][c.frame].sharpness; };
  for (size_t i = 0; i < all.size(); ++i) {
    std::vector<double> near;
    for (size_t k = i - std::min(i, kNeighbours); k < std::min(i + kNeighbours + 1, all.size()); ++k)
      if (all[k].film == all[i].film) near.push_back(sharpness(all[k]));
    if (sharpness(all[i]) < kSoft * upper_median(std::move(near)))
      ++choice.soft[all[i].film];
    else
      choice.frames.push_back(all[i]);
  }
  return choice;
}

}  // namespace vitrine
