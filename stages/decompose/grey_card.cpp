#include "stages/decompose/grey_card.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/config/photo_box.h"
#include "core/math/median.h"

namespace vitrine {

GreyCard parse_grey_card(const std::string& text, const std::vector<View>& views) {
  const auto fail = [&](std::string why) {
    return Error(ErrorKind::Usage, "the grey card cannot be found",
                 {.where = "decompose.grey_card = " + text,
                  .why = std::move(why),
                  .hint = "photo:x,y,w,h, pixels of the undistorted photo, for example IMG_0007.jpg:410,220,60,40",
                  .code = "GREY_CARD"});
  };
  const auto card = parse_photo_box(text);
  if (!card) throw fail("behind the photo's name belong four whole numbers: a box at least one pixel wide and high");
  const auto it = std::ranges::find_if(views, [&](const View& v) { return v.name == card->photo || v.stem() == card->photo; });
  if (it == views.end()) throw fail(fmt::format("no photo with a known camera is called '{}'", card->photo));
  const Intrinsics& k = it->intrinsics;
  if (card->width > k.width - card->x || card->height > k.height - card->y)
    throw fail(fmt::format("the box does not lie in the photo of {}x{} pixels", k.width, k.height));
  return {size_t(it - views.begin()), card->x, card->y, card->width, card->height};
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
    throw Error(ErrorKind::Input, "the grey card shows no surface",
                {.where = view.name, .hint = "a box inside the card, in a photo that shows it from near", .code = "GREY_CARD"});
  Vec3f out;
  for (size_t c = 0; c < 3; ++c) out[c] = std::max(1e-4f, upper_median_of(std::span(values[c])));
  return out;
}

}  // namespace vitrine
