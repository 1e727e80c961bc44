// Decodes mask files and computes their statistics.
#include <algorithm>
#include <set>

#include "core/foundation/base/error.h"
#include "core/intake/masks/mask_files.h"
#include "core/scene/image/ldr.h"

namespace vitrine {

namespace {

constexpr float kLabelLimit = 0.1f;      // 8-bit labels up to 25
constexpr float kNothing = 0.02f;        // black, up to JPEG noise
constexpr float kGreyTolerance = 0.02f;  // JPEG noise between the channels of a grey picture
constexpr double kColourShare = 0.02;    // of pixels: a picture with a larger coloured share is a photo

// Small labels and white, nothing between: a label map whose white is void, as PASCAL VOC and Cityscapes write it. Noise of a
// mask covers less.
bool is_label_map_with_void(const ImageF& mask) {
  constexpr double kLabelShare = 0.001;  // of the pixels
  size_t labels = 0, white = 0, black = 0;
  for (float v : mask.data()) labels += v > 0 && v < kLabelLimit, white += v >= 1, black += v <= 0;
  return white > 0 && labels + white + black == mask.data().size() && double(labels) > kLabelShare * double(mask.data().size());
}

}  // namespace

ImageF read_mask(const MaskFile& file, bool* void_label) {
  ImageF raw;
  try {
    raw = read_as_oriented(file.path);
  } catch (const Error& e) {
    throw Error(ErrorKind::Input, "cannot read a mask",
                {.where = file.path.string(),
                 .why = e.detail().why.empty() ? e.message() : e.detail().why,
                 .hint = "write it again as PNG, 8 or 16 bit, one channel",
                 .code = "MASK_UNREADABLE"});
  }
  const int channels = raw.channels();
  ImageF mask(raw.width(), raw.height(), 1);
  const size_t pixels = raw.pixel_count();
  const bool has_alpha = channels == 2 || channels == 4;
  float alpha_low = 1, alpha_high = 0;
  if (has_alpha)
    for (size_t i = 0; i < pixels; ++i) {
      const float a = raw.data()[i * size_t(channels) + size_t(channels) - 1];
      alpha_low = std::min(alpha_low, a);
      alpha_high = std::max(alpha_high, a);
    }
  const bool by_alpha = has_alpha && alpha_low < alpha_high;
  size_t coloured = 0;
  float highest = 0;
  for (size_t i = 0; i < pixels; ++i) {
    const float* p = &raw.data()[i * size_t(channels)];
    float v = p[0];
    if (by_alpha) {
      v = p[channels - 1];
    } else if (channels >= 3) {
      v = 0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2];
      coloured += std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]}) > kGreyTolerance;
    }
    mask.data()[i] = v;
    highest = std::max(highest, v);
  }
  if (double(coloured) > kColourShare * double(pixels)) {
    // One paint colour on black is a mask too; a photo has many colours.
    std::set<uint32_t> colours;
    for (size_t i = 0; i < pixels && colours.size() <= 8; ++i) {
      uint32_t packed = 0;
      for (size_t c = 0; c < 3; ++c) packed = packed << 8 | uint32_t(raw.data()[i * size_t(channels) + c] * 255.f + 0.5f);
      colours.insert(packed);
    }
    if (colours.size() > 8)
      throw Error(ErrorKind::Input, "a mask is a colour picture",
                  {.where = file.path.string(),
                   .why = fmt::format("{:.0f} % of its pixels have colour", 100.0 * double(coloured) / double(pixels)),
                   .hint = "masks are grey, 8 or 16 bit; keep photos out of the folder of masks",
                   .code = "MASK_NOT_GREY"});
    for (size_t i = 0; i < pixels; ++i) {
      const float* p = &raw.data()[i * size_t(channels)];
      mask.data()[i] = std::max({p[0], p[1], p[2]}) > 0 ? 1.f : 0.f;
    }
  } else if (const bool has_void = !by_alpha && is_label_map_with_void(mask);
             has_void || (highest > 0 && highest < kLabelLimit)) {
    for (float& v : mask.data()) v = v > 0 && v < kLabelLimit ? 1.f : 0.f;
    if (void_label != nullptr) *void_label = has_void;
  }
  return mask;
}

void MaskExtent::add(const ImageF& mask) {
  const int w = mask.width(), h = mask.height(), edge_x = std::max(1, w / 20), edge_y = std::max(1, h / 20);
  double sum = 0, border_sum = 0, centre_sum = 0;
  size_t border_count = 0, centre_count = 0;
  bool anything = false, everything = true;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const float v = mask.at(x, y);
      anything |= v > kNothing;
      everything &= v >= 1 - kNothing;
      sum += v;
      if (x < edge_x || y < edge_y || x >= w - edge_x || y >= h - edge_y) border_sum += v, ++border_count;
      if (3 * x >= w && 3 * x < 2 * w && 3 * y >= h && 3 * y < 2 * h) centre_sum += v, ++centre_count;
    }
  const double n = double(++masks);
  mean += (sum / double(mask.pixel_count()) - mean) / n;
  border += (border_sum / double(std::max<size_t>(border_count, 1)) - border) / n;
  centre += (centre_sum / double(std::max<size_t>(centre_count, 1)) - centre) / n;
  empty += !anything;
  full += everything;
}

bool looks_inverted(const MaskExtent& e) {
  constexpr double kMostly = 0.5, kBorder = 0.8, kHollow = 0.15;
  return e.mean > kMostly && e.border > kBorder && e.border - e.centre > kHollow;
}

}  // namespace vitrine
