#include "core/intake/photos/picture_content.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/photos/exif.h"
#include "core/intake/photos/measures.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/probe.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

constexpr float kGreyTolerance = 0.03f;  // JPEG noise between the channels of a grey picture
constexpr double kColourShare = 0.02;    // of pixels: a picture with a larger coloured share is not grey
constexpr float kLabelLimit = 0.1f;      // 8-bit labels up to 25
constexpr int kReach = 6;                // levels to either side over which JPEG spreads a level
constexpr double kFewLevels = 0.9;       // minimum share of a mask's pixels in its two most common levels
constexpr double kEnds = 0.75;           // or near its two ends: soft outlines are in between
constexpr size_t kFewColours = 32;       // labels or painted parts; a photo has thousands
constexpr size_t kMappedColours = 300;   // of a colour map of 256 entries, and of none
constexpr double kFlatShare = 0.8;       // of pixels equal to their neighbour: labels; sky and walls of photos have noise
constexpr double kBothShare = 0.001;     // of pixels: a smaller share is no class
constexpr size_t kHeadBytes = 1 << 18;   // larger than EXIF with a thumbnail

template <class F>
bool unless_undecodable(F&& f) {
  try {
    return f();
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    return false;
  }
}

double colour_share(const ImageF& image) {
  if (image.channels() < 3 || image.empty()) return 0;
  size_t coloured = 0;
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    const float* p = &image.data()[i * size_t(image.channels())];
    coloured += std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]}) > kGreyTolerance;
  }
  return double(coloured) / double(image.pixel_count());
}

// Of one channel of an image.
bool few_levels(const ImageF& image, int channel, bool both) {
  float highest = 0;
  const size_t n = image.pixel_count(), step = size_t(image.channels());
  const auto value = [&](size_t i) { return image.data()[i * step + size_t(channel)]; };
  for (size_t i = 0; i < n; ++i) highest = std::max(highest, value(i));
  const float scale = highest > 0 && highest < kLabelLimit ? 1 / highest : 1;
  std::array<double, 256> levels{};
  for (size_t i = 0; i < n; ++i) levels[size_t(std::clamp(value(i) * scale, 0.f, 1.f) * 255 + 0.5f)] += 1 / double(n);
  const auto around = [&](int level) {
    double sum = 0;
    for (int l = std::max(level - kReach, 0); l <= std::min(level + kReach, 255); ++l) sum += levels[size_t(l)];
    return sum;
  };
  const auto commonest = [&](int away_from) {
    int best = -1;
    for (int l = 0; l < 256; ++l)
      if ((away_from < 0 || std::abs(l - away_from) > 2 * kReach) && (best < 0 || levels[size_t(l)] > levels[size_t(best)]))
        best = l;
    return best;
  };
  const int first = commonest(-1), second = commonest(first);
  if (both && (around(first) < kBothShare || around(second) < kBothShare)) return false;
  const int top = int(std::min(highest * scale, 1.f) * 255 + 0.5f);
  size_t used = 0;
  for (double share : levels) used += share > 0;
  return around(first) + around(second) >= kFewLevels || used <= kFewColours ||
         (top > 4 * kReach && around(0) + around(top) >= kEnds);
}

bool few_colours(const ImageF& image, size_t limit = kFewColours) {
  std::set<uint32_t> colours;
  for (size_t i = 0; i < image.pixel_count() && colours.size() <= limit; ++i) {
    uint32_t packed = 0;
    for (size_t c = 0; c < 3; ++c)
      packed = packed << 8 | uint32_t(std::clamp(image.data()[i * size_t(image.channels()) + c], 0.f, 1.f) * 255.f + 0.5f);
    colours.insert(packed);
  }
  return colours.size() <= limit;
}

// Share of the pixels that have the value of their left neighbour.
double flat_share(const ImageF& image) {
  size_t same = 0;
  const int channels = std::min(image.channels(), 3);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 1; x < image.width(); ++x) {
      bool equal = true;
      for (int c = 0; c < channels; ++c) equal = equal && image.at(x, y, c) == image.at(x - 1, y, c);
      same += equal;
    }
  return image.pixel_count() > 0 ? double(same) / double(image.pixel_count()) : 0;
}

ImageF pixels_of(const fs::path& path, const PictureHead& head) {
  return head.format == PhotoFormat::Exr ? read_exr_rgb(path) : read_unchanged(path);
}

// Small and upright, for thumbnails.
PhotoMeasures small_measures(const fs::path& path, const PictureHead& head) {
  if (head.format == PhotoFormat::Exr) return measured(srgb8_from_linear(read_exr_rgb(path)));
  constexpr double kEnough = 200;  // pixels of the longest side
  int reduction = 1;
  while (reduction < 8 && std::max(head.width, head.height) / (2 * reduction) >= kEnough) reduction *= 2;
  const Image8 small = read_srgb8(path, reduction);
  if (head.orientation == 1) return measured(small);
  ImageF values(small.width(), small.height(), small.channels());
  for (size_t i = 0; i < values.data().size(); ++i) values.data()[i] = float(small.data()[i]);
  values = upright(values, head.orientation);
  Image8 turned(values.width(), values.height(), values.channels());
  for (size_t i = 0; i < turned.data().size(); ++i) turned.data()[i] = uint8_t(values.data()[i]);
  return measured(turned);
}

}  // namespace

PictureHead picture_head(const fs::path& path) {
  std::string bytes(kHeadBytes, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  Probe probe = probe_photo(bytes);
  if (probe.format == PhotoFormat::Tiff) probe = probe_photo(read_file(path));  // directories are often at the end of the file
  PictureHead head{
      .format = probe.format, .width = double(probe.width), .height = double(probe.height), .orientation = probe.orientation};
  if (probe.format == PhotoFormat::Jpeg || probe.format == PhotoFormat::Png)
    head.orientation = parse_exif(exif_block(bytes)).orientation;
  constexpr size_t kBitDepthAt = 24, kColourTypeAt = 25;  // byte offsets in a PNG header
  if (probe.format == PhotoFormat::Png && bytes.size() > kColourTypeAt) {
    head.bits = static_cast<unsigned char>(bytes[kBitDepthAt]);
    constexpr char kGreyAlpha = 4, kColourAlpha = 6;
    head.grey = bytes[kColourTypeAt] == 0;
    head.alpha = bytes[kColourTypeAt] == kGreyAlpha || bytes[kColourTypeAt] == kColourAlpha;
  }
  if (head.orientation >= 5) std::swap(head.width, head.height);
  return head;
}

bool looks_like_mask(const fs::path& path, const MaskLook& look) {
  const PictureHead head = picture_head(path);
  if (head.format == PhotoFormat::Raw) return false;
  // Decoding hundreds of large masks is slow, and no photograph is a PNG of a tenth of a byte per pixel.
  if (look.quick && head.format == PhotoFormat::Png) {
    constexpr double kPlain = 0.1;
    std::error_code ec;
    if (double(fs::file_size(path, ec)) < kPlain * head.width * head.height && !ec) return true;
  }
  return unless_undecodable([&] {
    const ImageF image = read_unchanged(path);
    const int channels = image.channels();
    if (look.alpha && (channels == 2 || channels == 4)) {
      bool varies = false;
      const size_t last = size_t(channels) - 1;
      for (size_t i = 0; i < image.pixel_count() && !varies; ++i)
        varies = image.data()[i * size_t(channels) + last] != image.data()[last];
      if (varies) return few_levels(image, channels - 1, look.both);
    }
    return colour_share(image) > kColourShare ? few_colours(image) : few_levels(image, 0, look.both);
  });
}

bool looks_like_depth(const fs::path& path, const fs::path& photo) {
  const PictureHead head = picture_head(path), beside = picture_head(photo);
  // An EXR next to photos in a camera format is no photograph; many depth maps have only a channel Z.
  if (head.format == PhotoFormat::Exr && beside.format != PhotoFormat::Exr) return true;
  constexpr int kManyBits = 16;
  if (head.grey && head.bits == kManyBits && !(beside.grey && beside.bits == kManyBits)) return true;
  return unless_undecodable([&] {
    const ImageF map = pixels_of(path, head);
    if (colour_share(map) > kColourShare)  // a colour map has up to 256 colours; a photo of 100 x 100 pixels has thousands
      return head.format == PhotoFormat::Png && few_colours(map, kMappedColours) &&
             !few_colours(pixels_of(photo, beside), kMappedColours);
    const ImageF other = pixels_of(photo, beside);
    return colour_share(other) > kColourShare || map.channels() < other.channels();
  });
}

bool looks_like_normals(const fs::path& path) {
  const PictureHead head = picture_head(path);
  return unless_undecodable([&] {
    const bool exr = head.format == PhotoFormat::Exr;
    const ImageF map = pixels_of(path, head);
    if (map.channels() < 3) return false;
    constexpr float kPositive = 0.02f;  // files without negative values clip them: only vectors without them have length 1
    size_t clipped_unit = 0, without_negative = 0;
    constexpr float kLow = 0.85f, kHigh = 1.15f;
    constexpr double kShare = 0.9;
    size_t unit = 0, none = 0;
    for (size_t i = 0; i < map.pixel_count(); ++i) {
      const float* p = &map.data()[i * size_t(map.channels())];
      const auto length = [&](float scale, float shift) {
        return std::hypot(scale * p[0] - shift, scale * p[1] - shift, scale * p[2] - shift);
      };
      const auto is_unit = [&](float l) { return l > kLow && l < kHigh; };
      const float spread = std::max({p[0], p[1], p[2]}) - std::min({p[0], p[1], p[2]});
      if (spread < kGreyTolerance)
        ++none;  // black, grey or white: no normal
      else
        unit += is_unit(length(2, 1)) || (exr && is_unit(length(1, 0)));
      if (spread >= kGreyTolerance && std::min({p[0], p[1], p[2]}) > kPositive)
        ++without_negative, clipped_unit += is_unit(length(1, 0));
    }
    constexpr size_t kLeast = 20;  // at least one pixel in so many has a normal
    if (clipped_unit * kLeast > map.pixel_count() && double(clipped_unit) >= kShare * double(without_negative)) return true;
    return unit * kLeast > map.pixel_count() && double(unit) >= kShare * double(map.pixel_count() - none);
  });
}

bool looks_like_confidence(const fs::path& path, const fs::path& photo) {
  return looks_like_mask(path, {.both = false, .alpha = false, .quick = true}) || looks_like_depth(path, photo);
}

bool looks_like_labels(const fs::path& path) {
  const PictureHead head = picture_head(path);
  constexpr int kManyBits = 16;
  if (head.grey && head.bits == kManyBits) return true;
  return unless_undecodable([&] {
    const ImageF map = pixels_of(path, head);
    return flat_share(map) >= kFlatShare || (colour_share(map) > kColourShare ? few_colours(map) : few_levels(map, 0, false));
  });
}

bool looks_like_pass(const fs::path& path, const fs::path& photo) {
  const PictureHead head = picture_head(path), beside = picture_head(photo);
  if (head.format == PhotoFormat::Jpeg || head.width != beside.width || head.height != beside.height) return false;
  constexpr double kAlike = 0.5;  // correlation of thumbnails
  return looks_like_depth(path, photo) ||
         unless_undecodable([&] { return likeness(small_measures(path, head), small_measures(photo, beside)) > kAlike; });
}

bool varying_alpha(const fs::path& path) {
  return unless_undecodable([&] {
    const ImageF image = read_unchanged(path);
    const size_t channels = size_t(image.channels()), last = channels - 1;
    if (channels != 2 && channels != 4) return false;
    for (size_t i = 0; i < image.pixel_count(); ++i)
      if (image.data()[i * channels + last] != image.data()[last]) return true;
    return false;
  });
}

// Both pictures in few cells: where the cut-out shows something, it shows the photo.
bool looks_like_cutout(const fs::path& path, const fs::path& photo, bool flat) {
  constexpr int kWide = 48, kHigh = 36;
  constexpr float kSolid = 0.95f, kNear = 0.1f, kOneColour = 0.02f;
  constexpr double kInside = 0.02, kOutside = 0.02, kSame = 0.8, kPlainBorder = 0.6;  // shares of cells
  return unless_undecodable([&] {
    const PictureHead head = picture_head(path), of = picture_head(photo);
    const ImageF full = upright(read_unchanged(path), head.orientation);
    const int channels = full.channels();
    const double scale = head.width / std::max(of.width, 1.0);
    if (head.width < 1 || std::abs(head.height - scale * of.height) > 2 * std::max(scale, 1.0)) return false;
    if (channels < 4 && !(flat && channels == 3)) return false;
    ImageF shown(full.width(), full.height(), 4, 1.f);  // premultiplied colour, alpha
    for (size_t i = 0; i < full.pixel_count(); ++i) {
      const float* p = &full.data()[i * size_t(channels)];
      const float a = channels == 4 ? p[3] : 1;
      for (size_t c = 0; c < 3; ++c) shown.data()[4 * i + c] = p[c] * a;
      shown.data()[4 * i + 3] = a;
    }
    const ImageF cells = resized(shown, kWide, kHigh), real = resized(upright(read_srgb(photo), of.orientation), kWide, kHigh);
    const float* corner = &cells.data()[0];
    const auto plain = [&](const float* p) {
      return std::max({std::abs(p[0] - corner[0]), std::abs(p[1] - corner[1]), std::abs(p[2] - corner[2])}) < kOneColour;
    };
    size_t inside = 0, outside = 0, same = 0, border = 0, plain_border = 0;
    for (int y = 0; y < kHigh; ++y)
      for (int x = 0; x < kWide; ++x) {
        const size_t i = size_t(y) * kWide + size_t(x);
        const float *p = &cells.data()[4 * i], *q = &real.data()[3 * i];
        const bool hidden = channels == 4 ? p[3] < 1 - kSolid : plain(p);
        if (x == 0 || y == 0 || x == kWide - 1 || y == kHigh - 1) ++border, plain_border += plain(p);
        outside += hidden;
        if (hidden || p[3] < kSolid) continue;
        ++inside;
        same += std::max({std::abs(p[0] / p[3] - q[0]), std::abs(p[1] / p[3] - q[1]), std::abs(p[2] / p[3] - q[2])}) < kNear;
      }
    constexpr double kCells = double(kWide) * kHigh;
    if (channels < 4 && double(plain_border) < kPlainBorder * double(border)) return false;
    return double(inside) > kInside * kCells && double(outside) > kOutside * kCells && double(same) > kSame * double(inside);
  });
}

const PictureHead& CopyFinder::head(const fs::path& path) {
  const auto known = heads_.find(path);
  return known != heads_.end() ? known->second : heads_.emplace(path, picture_head(path)).first->second;
}

bool CopyFinder::looks_like_copy(const fs::path& copy, const fs::path& of, bool shrunk) {
  // Correlation of thumbnails: copies of 80 x 60 pixels reach 0.994, larger ones 0.9995; neighbouring photos of a rig stay below
  // 0.97.
  constexpr double kShrunk = 1.4, kAlike = 0.985, kMuchAlike = 0.6;
  const PictureHead &small = head(copy), &large = head(of);
  if (small.width < 1 || large.width < 1) return false;
  const double across = large.width / small.width, down = large.height / small.height;
  if (shrunk) {
    // Sides of the reduced picture may be rounded up or down.
    const bool proportional =
        std::abs(large.height - across * small.height) <= across + 1 || std::abs(large.width - down * small.width) <= down + 1;
    if (across < kShrunk || !proportional) return false;
  }
  return unless_undecodable(
      [&] { return likeness(small_measures(copy, small), small_measures(of, large)) >= (shrunk ? kAlike : kMuchAlike); });
}

}  // namespace vitrine
