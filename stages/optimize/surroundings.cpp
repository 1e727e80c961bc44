#include "stages/optimize/surroundings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"
#include "stages/optimize/moving_evidence.h"

namespace vitrine {

namespace {

constexpr double kMostOutside = 0.1, kMostDissent = 0.1;
constexpr double kMostlyStill = 0.4;  // of the pixels around the object: enough to decide without sparse points
constexpr double kLeastStill = 0.05;  // of the pixels around the object: a smaller static part is not trained

enum class Seen : unsigned char { Not, Inside, Outside };

Seen seen(const Capture& capture, const Targets& targets, size_t photo, const Vec3d& position) {
  const auto& mask = targets.photos[photo][0].masks[static_cast<size_t>(MaskClass::Object)];
  if (mask.empty()) return Seen::Not;
  const View& view = capture.photos[photo].levels[0].view;
  const auto p = image_point(position, view);
  if (!p) return Seen::Not;
  const size_t pixel = size_t(p->y) * size_t(view.intrinsics.width) + size_t(p->x);
  const auto& ignore = targets.photos[photo][0].masks[static_cast<size_t>(MaskClass::Ignore)];
  if (!ignore.empty() && ignore[pixel] >= 128) return Seen::Not;
  return mask[pixel] >= 128 ? Seen::Inside : Seen::Outside;
}

// Widens the object masks by the static mask (`shown`, at the level of the depth maps); its boundary is ignored. In photos
// without an object mask, all pixels outside the static mask are ignored.
void widen_masks(const Capture& capture, const std::vector<uint8_t>& shown, size_t shown_level, size_t photo, Targets& targets) {
  const Intrinsics& from = capture.photos[photo].levels[shown_level].view.intrinsics;
  ImageF still(from.width, from.height, 1), rim(from.width, from.height, 1);
  for (size_t i = 0; i < shown.size(); ++i) still.data()[i] = shown[i] == 255, rim.data()[i] = shown[i] == 128;
  const auto byte = [](float value) { return static_cast<uint8_t>(std::lround(255.f * std::clamp(value, 0.f, 1.f))); };
  for (size_t level = 0; level < kLevels; ++level) {
    const Intrinsics& k = capture.photos[photo].levels[level].view.intrinsics;
    const ImageF still_here = resized(still, k.width, k.height), rim_here = resized(rim, k.width, k.height);
    auto& masks = targets.photos[photo][level].masks;
    auto &object = masks[size_t(MaskClass::Object)], &ignore = masks[size_t(MaskClass::Ignore)];
    const bool has_mask = !object.empty();
    object.resize(still_here.pixel_count(), 0);
    ignore.resize(still_here.pixel_count(), 0);
    for (size_t i = 0; i < object.size(); ++i) {
      const bool inside = still_here.data()[i] >= 0.5f, at_rim = has_mask ? rim_here.data()[i] > 0 : !inside;
      if (inside)
        object[i] = 255;
      else if (at_rim && object[i] < 128)
        ignore[i] = std::max(ignore[i], byte(has_mask ? 2 * rim_here.data()[i] : 1.f));
    }
  }
}

}  // namespace

double sightings_outside_object(const Capture& capture, const Targets& targets) {
  size_t all = 0, outside = 0;
  for (const ScenePoint& point : capture.view_set.points)
    for (uint32_t photo : point.views) {
      const Seen how = seen(capture, targets, photo, point.position);
      all += how != Seen::Not;
      outside += how == Seen::Outside;
    }
  return all > 0 ? double(outside) / double(all) : 1;
}

Surroundings surroundings_to_train(WantedSurroundings wanted, const Passes& passes, const Capture& capture,
                                   const std::function<const DenseDepth&()>& dense, Targets& targets) {
  if (wanted == WantedSurroundings::Train || !targets.any(MaskClass::Object)) return {};
  if (wanted == WantedSurroundings::Ignore) return {Trained::ObjectAlone, {}};
  if (passes.size() > 1)
    return {Trained::ObjectAlone, fmt::format("{}, and what surrounds the object stands elsewhere in each", passes_text(passes))};
  const double outside = sightings_outside_object(capture, targets);
  const DenseDepth& depth = dense();
  const MovingEvidence evidence = moving_evidence(capture, targets, depth);
  EvidenceCounts counts = evidence.counts;
  const auto everything = [&] {
    return Surroundings{Trained::Everything,
                        fmt::format("the surroundings stand still with the object: other photos confirm {:.0f} % of what says "
                                    "something of it around the masks; {:.0f} % stand still before the camera instead",
                                    100 * counts.part(counts.still), 100 * counts.part(counts.in_place + counts.plain))};
  };
  const bool explained =
      outside >= kMostOutside || (counts.still > 0 && double(counts.still) >= kMostlyStill * double(counts.all));
  if (explained && !counts.moving()) return everything();
  const std::vector<StillPoint> points = still_points(capture, depth, evidence);
  std::vector<std::vector<uint8_t>> shown_in(capture.photos.size());
  parallel_for(capture.photos.size(), 1, [&](size_t i) {
    shown_in[i] = shown(capture.photos[i].levels[depth.level].view, points,
                        targets.photos[i][depth.level].masks[size_t(MaskClass::Object)], evidence.photos[i]);
  });
  // White paper between pencil marks also looks constant in place without moving.
  size_t still = 0;
  for (uint32_t v : capture.train) {
    const PhotoEvidence& of = evidence.photos[v];
    for (size_t i = 0; i < of.pixels.size(); ++i) {
      still += shown_in[v][i] == 255 && of.pixels[i] != Evidence::Object;
      counts.plain -= of.plain[i] && shown_in[v][i] != 0;
    }
  }
  if (explained && !counts.moving()) return everything();
  const double share = counts.all > 0 ? double(still) / double(counts.all) : 0;
  const std::string figures = fmt::format(
      "of the pixels around its masks {:.0f} % stand still with it, {:.0f} % before the camera, {:.0f} % are explained by "
      "neither; "
      "{:.1f} % of the sightings of sparse points lie outside the masks",
      100 * share, 100 * double(counts.in_place + counts.plain) / double(std::max<size_t>(counts.all, 1)),
      100 * double(counts.unexplained) / double(std::max<size_t>(counts.all, 1)), 100 * outside);
  // On a plain backdrop with almost no sparse points on the plate, static evidence next to the object is noise.
  const bool by_points = outside >= kMostOutside || counts.moving_by_texture();
  if (share < kLeastStill || !by_points) return {Trained::ObjectAlone, figures};
  for (size_t i = 0; i < shown_in.size(); ++i) widen_masks(capture, shown_in[i], depth.level, i, targets);
  targets.has[size_t(MaskClass::Ignore)] = true;
  return {Trained::StillPart, figures};
}

void keep_largest_pass(const Passes& passes, Capture& capture) {
  if (passes.size() < 2) return;
  const auto elsewhere = [&](uint32_t photo) {
    return std::find(passes[0].begin(), passes[0].end(), capture.photos[photo].name()) == passes[0].end();
  };
  std::erase_if(capture.train, elsewhere);
  std::erase_if(capture.heldout, elsewhere);
}

bool on_object(const Capture& capture, const Targets& targets, const Vec3d& position) {
  size_t all = 0, outside = 0;
  for (uint32_t photo : capture.train) {
    const Seen how = seen(capture, targets, photo, position);
    all += how != Seen::Not;
    outside += how == Seen::Outside;
  }
  return double(outside) <= kMostDissent * double(all);
}

}  // namespace vitrine
