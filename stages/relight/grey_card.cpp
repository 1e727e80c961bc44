#include "stages/relight/grey_card.h"

#include <algorithm>
#include <cstdio>

#include "core/base/error.h"

namespace vitrine {

GreyCard parse_grey_card(const std::string& text, const std::vector<View>& views) {
  const auto fail = [&](std::string why) {
    return Error(ErrorKind::Usage, "the grey card cannot be found",
                 {.where = "relight.grey_card = " + text,
                  .why = std::move(why),
                  .hint = "photo:x,y,w,h, pixels of the undistorted photo, for example IMG_0007.jpg:410,220,60,40",
                  .code = "GREY_CARD"});
  };
  const size_t colon = text.rfind(':');
  GreyCard card;
  int end = 0;
  if (colon == std::string::npos ||
      std::sscanf(text.c_str() + colon + 1, "%d,%d,%d,%d%n", &card.x, &card.y, &card.width, &card.height, &end) != 4 ||
      colon + 1 + size_t(end) != text.size())
    throw fail("four whole numbers belong behind the photo's name");
  const std::string name = text.substr(0, colon);
  const auto it = std::ranges::find_if(views, [&](const View& v) { return v.name == name || v.stem() == name; });
  if (it == views.end()) throw fail(fmt::format("no view is called '{}'", name));
  const Intrinsics& k = it->intrinsics;
  if (card.width < 1 || card.height < 1 || card.x < 0 || card.y < 0 || card.width > k.width - card.x ||
      card.height > k.height - card.y)
    throw fail(fmt::format("the box does not lie in the photo of {}x{} pixels", k.width, k.height));
  card.view = size_t(it - views.begin());
  return card;
}

Vec3f median_in(const GreyCard& card, const View& view, const ImageF& picture) {
  const double sx = double(picture.width()) / view.intrinsics.width, sy = double(picture.height()) / view.intrinsics.height;
  const auto at = [](double v, int size) { return std::clamp(int(v), 0, size - 1); };
  std::vector<float> values[3];
  for (int y = at(card.y * sy, picture.height()); y <= at((card.y + card.height) * sy - 1e-6, picture.height()); ++y)
    for (int x = at(card.x * sx, picture.width()); x <= at((card.x + card.width) * sx - 1e-6, picture.width()); ++x) {
      const float* p = picture.pixel(x, y);
      if (!(p[0] + p[1] + p[2] > 0)) continue;
      for (size_t c = 0; c < 3; ++c) values[c].push_back(p[c]);
    }
  if (values[0].empty())
    throw Error(ErrorKind::Input, "the grey card shows no surface", {.where = view.name, .code = "GREY_CARD"});
  Vec3f out;
  for (size_t c = 0; c < 3; ++c) {
    const auto middle = values[c].begin() + std::ptrdiff_t(values[c].size() / 2);
    std::nth_element(values[c].begin(), middle, values[c].end());
    out[c] = std::max(1e-4f, *middle);
  }
  return out;
}

}  // namespace vitrine
