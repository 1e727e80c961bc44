#include "stages/masks/boxes/past_outlines.h"

#include "core/base/parallel.h"
#include "core/base/process.h"
#include "stages/masks/boxes/outline_cut.h"

namespace vitrine {

std::vector<HalfSpace> PastOutlines::sides(const VisualHull& hull) const {
  return sides_of_cameras(stereo_.surroundings().planes, stereo_.views(), hull.bounds());
}

std::vector<std::vector<uint8_t>> PastOutlines::hidden(const VisualHull& around) const {
  const Surroundings scene = stereo_.surroundings();
  const std::span<const View> views = stereo_.views();
  std::vector<std::vector<uint8_t>> hidden(views.size());
  parallel_for(views.size(), 1, [&](size_t v) { hidden[v] = hidden_pixels(scene.maps[v], hull_depths(around, views[v])); });
  return hidden;
}

std::vector<Silhouette> PastOutlines::outlines(const VisualHull& hull, std::span<const std::vector<uint8_t>> hidden) const {
  const Surroundings scene = stereo_.surroundings();
  const std::span<const View> views = stereo_.views();
  const std::vector<std::vector<uint8_t>> about = silhouettes_of(hull, views);
  std::vector<HullDepths> passed(views.size());
  parallel_for(views.size(), 1, [&](size_t v) { passed[v] = hull_depths(hull, views[v]); });
  std::vector<Silhouette> found(views.size());
  parallel_for(views.size(), 1, [&](size_t v) {
    if (interrupt_signal() != 0) return;
    found[v] = silhouette(views[v], outline_cut(scene.photos[v], unexplained(scene, hull, passed, v), about[v]));
    for (size_t i = 0; i < hidden[v].size(); ++i)
      if (hidden[v][i]) found[v].value.data()[i] = -1;
  });
  throw_if_interrupted();
  return found;
}

}  // namespace vitrine
