#include "stages/sfm/zoom_groups.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "core/foundation/base/error.h"

namespace vitrine {

void part_by_zoom(std::vector<SfmPhoto>& list, std::span<const Photo> photos) {
  VITRINE_CHECK(list.size() == photos.size(), "one entry for each photo");
  constexpr double kStep = 1.03;  // focus changes the focal length that cameras write by less
  using Key = std::tuple<std::string, int, int, std::optional<double>>;
  std::map<Key, std::vector<size_t>> cameras;
  for (size_t i = 0; i < list.size(); ++i)
    if (photos[i].zoom) {
      const auto [shortest, longest] = std::minmax(list[i].width, list[i].height);
      cameras[{list[i].camera, shortest, longest, list[i].focal_px}].push_back(i);
    }
  for (auto& [key, members] : cameras) {
    std::ranges::stable_sort(members, {}, [&](size_t i) { return *photos[i].zoom; });
    const double widest = *photos[members[0]].zoom;
    double first = widest;
    for (const size_t i : members) {
      const double zoom = *photos[i].zoom;
      if (zoom > kStep * first) first = zoom;
      if (first == widest) continue;
      list[i].camera += fmt::format(" zoom {:.3f}", first);
      if (list[i].focal_px) *list[i].focal_px *= first / widest;
    }
  }
}

}  // namespace vitrine
