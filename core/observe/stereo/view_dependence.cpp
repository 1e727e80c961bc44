#include "core/observe/stereo/view_dependence.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/median.h"

namespace vitrine {

namespace {

constexpr double kLeastCosine = 0.35;  // between view direction and normal: at grazing angles a clear coat is a mirror
constexpr size_t kFewestViews = 4, kFewestPlaces = 30;
constexpr double kBlank = 0.01;                      // luminance spread of textureless photos
constexpr Vec3d kLuminance{0.2126, 0.7152, 0.0722};  // Rec. 709

// Standard deviation without the brightest and darkest tenth of the values: one photo may show a highlight of a lamp.
double trimmed_spread(std::vector<double>& values) {
  std::ranges::sort(values);
  const size_t out = values.size() / 10;
  double sum = 0, squares = 0;
  const double count = double(values.size() - 2 * out);
  for (size_t i = out; i + out < values.size(); ++i) sum += values[i], squares += values[i] * values[i];
  return std::sqrt(std::max(0.0, squares / count - sum * sum / (count * count)));
}

}  // namespace

LuminancePhoto luminance_photo(const View& view, const ImageF& linear, int side) {
  LuminancePhoto out{view, {}, {}};
  out.view.intrinsics = view.intrinsics.limited_to(side);
  const ImageF small = resized(linear, out.view.intrinsics.width, out.view.intrinsics.height);
  out.luminance = ImageF(small.width(), small.height(), 1);
  for (size_t p = 0; p < out.luminance.data().size(); ++p) {
    double sum = 0;
    for (size_t c = 0; c < 3; ++c) sum += kLuminance[c] * double(small.data()[3 * p + c]) / view.gain[c];
    out.luminance.data()[p] = std::clamp(srgb_from_linear(static_cast<float>(sum)), 0.f, 1.f);
  }
  out.inside.assign(out.luminance.data().size(), 0);
  return out;
}

double luminance_spread(std::span<const LuminancePhoto> photos) {
  double sum = 0, squares = 0, count = 0;
  for (const LuminancePhoto& photo : photos)
    for (const float value : photo.luminance.data()) sum += double(value), squares += double(value) * double(value), ++count;
  return count > 0 ? std::sqrt(std::max(0.0, squares / count - sum * sum / (count * count))) : 0;
}

std::optional<double> view_dependence(std::span<const ShapePoint> surface, const ViewDependenceDesc& desc) {
  if (!(desc.photo_spread > kBlank)) return std::nullopt;
  std::vector<double> spreads(surface.size(), -1);
  parallel_for(surface.size(), 16, [&](size_t i) {
    const ShapePoint& place = surface[i];
    std::vector<double> seen;
    for (size_t v = 0; v < desc.photos.size(); ++v) {
      const LuminancePhoto& photo = desc.photos[v];
      const auto at = image_point(place.position, photo.view, 1e-6);
      if (!at || !photo.inside[photo.luminance.index(int(at->x), int(at->y))]) continue;
      if (dot(place.normal, normalized(photo.view.centre_in_world() - place.position)) < kLeastCosine) continue;
      if (desc.hidden(v, place.position)) continue;
      float value = 0;
      sample_bilinear(photo.luminance, at->x, at->y, &value);
      seen.push_back(double(value));
    }
    if (seen.size() >= kFewestViews) spreads[i] = trimmed_spread(seen);
  });
  std::erase_if(spreads, [](double s) { return s < 0; });
  if (spreads.size() < kFewestPlaces) return std::nullopt;
  return upper_median(std::move(spreads)) / desc.photo_spread;
}

}  // namespace vitrine
