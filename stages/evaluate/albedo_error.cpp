#include "stages/evaluate/albedo_error.h"

#include <algorithm>
#include <cmath>

#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {

namespace {

constexpr double kGamma = 2.2;  // of the published protocol, not the sRGB curve
constexpr size_t kFewest = 64;  // minimum counted pixels of a view
constexpr float kAllPainted = 0.999f;

}  // namespace

void AlbedoError::add(const AlbedoPicture& ours, const TruthPicture& truth) {
  const bool finer = ours.intrinsics.width > truth.intrinsics.width;
  const Intrinsics k = finer ? ours.intrinsics.limited_to(truth.intrinsics.longest_side()) : ours.intrinsics;
  const double shrink = std::max(1.0, double(truth.intrinsics.width) / k.width);
  const Intrinsics from = truth.intrinsics.scaled_to(int(std::lround(truth.intrinsics.width / shrink)),
                                                     int(std::lround(truth.intrinsics.height / shrink)));
  ImageF full_paint(truth.radiance.width(), truth.radiance.height(), 1);
  for (size_t i = 0; i < full_paint.data().size(); ++i) {
    const float* t = &truth.radiance.data()[3 * i];
    full_paint.data()[i] = t[0] > 0 && t[1] > 0 && t[2] > 0 ? 1.f : 0.f;
  }
  const ImageF map = at_size(truth.radiance, from), paint = at_size(full_paint, from), albedo = at_size(ours.albedo, k);
  const ImageF radiance = at_size(ours.radiance, k);
  const ImageF object = ours.object ? at_size(*ours.object, k) : ImageF(k.width, k.height, 1, 1.f);
  const ImageF glass = ours.glass ? at_size(*ours.glass, k) : ImageF(k.width, k.height, 1, 0.f);
  std::vector<Pixel> pixels;
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const auto at = image_point(truth.truth_from_ours * k.ray(x + 0.5, y + 0.5), from);
      if (!at) continue;
      float t[3], painted;
      sample_bilinear(map, at->x, at->y, t);
      sample_bilinear(paint, at->x, at->y, &painted);
      const float *o = albedo.pixel(x, y), *r = radiance.pixel(x, y);
      if (!(painted > kAllPainted) || !(o[0] + o[1] + o[2] > 0)) continue;
      const bool on_object = object.at(x, y) > 0.5f, behind = glass.at(x, y) > 0;
      pixels.push_back({{o[0], o[1], o[2]},
                        {r[0], r[1], r[2]},
                        {t[0], t[1], t[2]},
                        !on_object ? kRest
                        : behind   ? kThroughGlass
                                   : kObject});
    }
  views_.push_back(std::move(pixels));
}

std::optional<double> AlbedoError::psnr(Guess guess, const Vec3d& scale, const std::vector<bool>& regions) const {
  double sum = 0;
  size_t views = 0;
  for (const auto& view : views_) {
    double squares = 0;
    size_t count = 0;
    for (const Pixel& p : view) {
      if (!regions[p.region]) continue;
      ++count;
      for (size_t c = 0; c < 3; ++c) {
        const double ours = std::pow(std::clamp(scale[c] * double((p.*guess)[c]), 0.0, 1.0), 1 / kGamma);
        const double truth = std::pow(std::min(1.0, double(p.truth[c])), 1 / kGamma);
        squares += (ours - truth) * (ours - truth);
      }
    }
    if (count < kFewest) continue;
    sum += -10 * std::log10(std::max(1e-12, squares / (3.0 * double(count))));
    ++views;
  }
  if (views == 0) return std::nullopt;
  return sum / double(views);
}

Vec3d AlbedoError::scale_of(Guess guess) const {
  Vec3d scale{1, 1, 1};
  // The object outside the glass; if it is empty, larger regions.
  for (const std::vector<bool>& regions : {std::vector<bool>{true, false, false}, {true, true, false}, {true, true, true}}) {
    std::vector<double> ratio[3];
    for (const auto& view : views_)
      for (const Pixel& p : view)
        for (size_t c = 0; c < 3; ++c)
          if (regions[p.region] && (p.*guess)[c] > 1e-4f) ratio[c].push_back(double(p.truth[c]) / double((p.*guess)[c]));
    if (ratio[0].size() < kFewest || ratio[1].size() < kFewest || ratio[2].size() < kFewest) continue;
    for (size_t c = 0; c < 3; ++c) scale[c] = median(std::move(ratio[c]));
    break;
  }
  return scale;
}

AlbedoScores AlbedoError::scores() const {
  AlbedoScores out;
  out.views = views_.size();
  out.scale = scale_of(&Pixel::ours);
  out.psnr = psnr(&Pixel::ours, out.scale, {true, false, false});
  out.through_glass = psnr(&Pixel::ours, out.scale, {false, true, false});
  out.everywhere = psnr(&Pixel::ours, out.scale, {true, true, true});
  out.undecomposed = psnr(&Pixel::radiance, scale_of(&Pixel::radiance), {true, false, false});
  return out;
}

}  // namespace vitrine
