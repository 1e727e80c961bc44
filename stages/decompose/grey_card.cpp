#include "stages/decompose/grey_card.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/foundation/math/median.h"

namespace vitrine {

namespace {

constexpr float kDarkestCard = 0.004f;   // of a linear 8-bit photo: darker values are dominated by rounding
constexpr float kBrightestCard = 0.95f;  // brighter values are clipped
constexpr double kLeastUsable = 0.5;     // of the box: with fewer pixels the median would be biased to dark values
constexpr size_t kFewestShared = 200;    // pixels with both photo and scene
constexpr float kGainError_log = 0.25f;  // tolerance of a photo's gain; a quarter of a stop is usual on not quite matt surfaces
constexpr double kShortestUp = 0.2;      // length of the mean up vector; shorter: the cameras look straight down

// Calls `take` for the pixels inside the box, in a picture of the view at any size.
template <class F>
void for_each_card_pixel(const GreyCard& card, const View& view, const ImageF& picture, const F& take) {
  const double sx = double(picture.width()) / view.intrinsics.width, sy = double(picture.height()) / view.intrinsics.height;
  const auto at = [](double v, int size) { return std::clamp(int(v), 0, size - 1); };
  for (int y = at(card.y * sy, picture.height()); y <= at((card.y + card.height) * sy - 1e-6, picture.height()); ++y)
    for (int x = at(card.x * sx, picture.width()); x <= at((card.x + card.width) * sx - 1e-6, picture.width()); ++x)
      take(picture.pixel(x, y));
}

bool not_black(const float* p) { return p[0] + p[1] + p[2] > 0; }

Error unusable_card(const char* what, const View& view, std::string why, std::string hint) {
  return Error(ErrorKind::Input, what, {.where = view.name, .why = std::move(why), .hint = std::move(hint), .code = "GREY_CARD"});
}

}  // namespace

Vec3f median_in(const GreyCard& card, const View& view, const ImageF& picture) {
  std::vector<float> values[3];
  for_each_card_pixel(card, view, picture, [&](const float* p) {
    if (!not_black(p)) return;
    for (size_t c = 0; c < 3; ++c) values[c].push_back(p[c]);
  });
  if (values[0].empty())
    throw unusable_card("the grey card shows no surface", view, {}, "a box inside the card, in a photo that shows it from near");
  Vec3f out;
  for (size_t c = 0; c < 3; ++c) out[c] = std::max(1e-4f, upper_median_of(std::span(values[c])));
  return out;
}

double shown_share(const GreyCard& card, const View& view, const ImageF& picture) {
  size_t all = 0, shown = 0;
  for_each_card_pixel(card, view, picture, [&](const float* p) { ++all, shown += not_black(p); });
  return double(shown) / double(all);
}

Vec3f photographed(const GreyCard& card, const View& view, const ImageF& photo) {
  std::vector<float> values[3];
  size_t all = 0, clipped = 0;
  for_each_card_pixel(card, view, photo, [&](const float* p) {
    ++all;
    if (std::max({p[0], p[1], p[2]}) > kBrightestCard) {
      ++clipped;
    } else if (not_black(p)) {
      for (size_t c = 0; c < 3; ++c) values[c].push_back(p[c]);
    }
  });
  const auto percent = [&](size_t n) { return 100 * double(n) / double(all); };
  constexpr const char* kWhat = "the grey card cannot be measured in the photo";
  if (double(clipped) > (1 - kLeastUsable) * double(all))
    throw unusable_card(kWhat, view, fmt::format("{:.0f} % of the box are overexposed", percent(clipped)),
                        "a darker patch, grey instead of white with its own grey_albedo, or a darker photo");
  if (double(values[0].size()) < kLeastUsable * double(all))
    throw unusable_card(kWhat, view, fmt::format("{:.0f} % of the box are black", percent(all - clipped - values[0].size())),
                        "a box inside the card");
  Vec3f out;
  for (size_t c = 0; c < 3; ++c) out[c] = upper_median_of(std::span(values[c]));
  if (std::min({out.x, out.y, out.z}) < kDarkestCard)
    throw unusable_card(kWhat, view, fmt::format("its colour is {:.4f} {:.4f} {:.4f} of white: too dark", out.x, out.y, out.z),
                        "a grey patch, or a brighter photo");
  return out;
}

std::optional<Vec3f> gain_by_scene(const ImageF& photo, const ImageF& rendered) {
  const double sx = double(photo.width()) / rendered.width(), sy = double(photo.height()) / rendered.height();
  std::vector<float> ratios[3];
  for (int y = 0; y < rendered.height(); ++y)
    for (int x = 0; x < rendered.width(); ++x) {
      const float *shown = rendered.pixel(x, y), *seen = photo.pixel(int((x + 0.5) * sx), int((y + 0.5) * sy));
      for (size_t c = 0; c < 3; ++c)
        if (shown[c] > kDarkestCard && seen[c] > kDarkestCard && seen[c] < kBrightestCard)
          ratios[c].push_back(seen[c] / shown[c]);
    }
  Vec3f out;
  for (size_t c = 0; c < 3; ++c) {
    if (ratios[c].size() < kFewestShared) return std::nullopt;
    out[c] = upper_median_of(std::span(ratios[c]));
  }
  return out;
}

CardInPhoto albedo_of_card(const GreyCard& card, const View& view, const PhotoOfCard& seen) {
  const Vec3f photographed_card = photographed(card, view, seen.photo);
  const auto gain = gain_by_scene(seen.photo, seen.rendered);
  const auto solved = cast<float>(view.gain);
  const Vec3f &by = gain ? *gain : solved, &light = seen.light;
  if (!(std::min({light.x, light.y, light.z}) > 0))
    throw Error(ErrorKind::Input, "the light on the grey card is not known",
                {.where = view.name,
                 .why = "the light that was found has a channel without any light from above",
                 .hint = "leave out decompose.grey_card",
                 .code = "GREY_CARD"});
  CardInPhoto out;
  Vec3f drift;
  bool drifts = false;
  for (size_t c = 0; c < 3; ++c) {
    out.albedo[c] = std::numbers::pi_v<float> * photographed_card[c] / by[c] / light[c];
    drift[c] = by[c] / solved[c];
    drifts = drifts || std::abs(std::log(drift[c])) > kGainError_log;
  }
  if (drifts) out.drift = drift;
  return out;
}

Vec3f up_in_photo(const View& view, const std::vector<View>& views, const Passes& passes) {
  const size_t pass = pass_of(passes, view.name);
  if (pass == 0) return {0, 0, 1};
  Vec3d sum{};
  size_t count = 0;
  for (const View& v : views)
    if (pass_of(passes, v.name) == pass) sum += transposed_times(v.cam_from_world.rotation, Vec3d{0, -1, 0}), ++count;
  if (!(length(sum) > kShortestUp * double(count)))
    throw unusable_card("the light on the grey card is not known", view,
                        "the cameras of its pass look straight down, so that the upward direction is unknown",
                        "the card in a photo of the first pass");
  return cast<float>(normalized(sum));
}

}  // namespace vitrine
