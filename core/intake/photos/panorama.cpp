#include "core/intake/photos/panorama.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "core/foundation/math/median.h"
#include "core/scene/camera/lens_circle.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr std::string_view kNameSpace = "http://ns.google.com/photos/1.0/panorama/";
constexpr int kTestWidth = 512;  // pixels, of the picture that is examined
constexpr int kLeastWidth = 64;
constexpr double kSeamCorrelation = 0.5;  // of the two edges, without what the whole rows and wide parts of the columns show
constexpr double kSeamTexture = 0.008;    // standard deviation along an edge, of a range of 1
constexpr double kPoleTexture = 0.003;    // mean difference between two rows
constexpr double kPoleStretch = 0.35;     // of horizontal to vertical differences, relative to those of the middle rows
constexpr double kSizeTolerance = 0.005;

// Value of an attribute or an element, `name` with its prefix; empty if missing.
std::string_view xmp_value(std::string_view packet, const std::string& name) {
  constexpr size_t kLongest = 64;
  for (size_t at = packet.find(name); at != std::string_view::npos; at = packet.find(name, at + 1)) {
    std::string_view rest = packet.substr(at + name.size(), kLongest);
    const size_t begin = rest.find_first_not_of(" \t\r\n=");
    if (begin == std::string_view::npos) continue;
    const char opening = rest[begin];
    if (opening != '"' && opening != '\'' && opening != '>') continue;
    rest.remove_prefix(begin + 1);
    const size_t end = rest.find(opening == '>' ? '<' : opening);
    if (end != std::string_view::npos) return rest.substr(0, end);
  }
  return {};
}

int whole_number(std::string_view text) {
  constexpr int kMost = 1 << 20;
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && value > 0 && value <= kMost ? value : 0;
}

bool twice_as_wide(int width, int height) {
  return height > 0 && std::abs(width - 2 * height) <= std::max(2.0, kSizeTolerance * width);
}

ImageF grey(const ImageF& image) {
  ImageF out(image.width(), image.height(), 1);
  const size_t channels = size_t(image.channels());
  for (size_t i = 0; i < out.pixel_count(); ++i) {
    for (size_t c = 0; c < channels; ++c) out.data()[i] += image.data()[channels * i + c];
    out.data()[i] /= float(channels);
  }
  return out;
}

// A column without the median of each row, and without its own mean over an eighth of the height: an ordinary photo has the same
// sky, horizon and floor at both edges.
std::vector<double> column_texture(const ImageF& grey, const std::vector<double>& row_median, int x) {
  const int h = grey.height(), reach = std::max(h / 16, 2);
  std::vector<double> value(size_t(h), 0.0), out(size_t(h), 0.0);
  for (int y = 0; y < h; ++y) value[size_t(y)] = double(grey.at(x, y)) - row_median[size_t(y)];
  for (int y = 0; y < h; ++y) {
    double mean = 0;
    const int first = std::max(y - reach, 0), last = std::min(y + reach, h - 1);
    for (int k = first; k <= last; ++k) mean += value[size_t(k)] / (last - first + 1);
    out[size_t(y)] = value[size_t(y)] - mean;
  }
  return out;
}

bool seam_continues(const ImageF& grey) {
  const int w = grey.width(), h = grey.height();
  std::vector<double> row_median;
  for (int y = 0; y < h; ++y)
    row_median.push_back(double(upper_median(std::vector<float>(grey.pixel(0, y), grey.pixel(0, y) + w))));
  const std::vector<double> left = column_texture(grey, row_median, 0), right = column_texture(grey, row_median, w - 1);
  double ll = 0, rr = 0, lr = 0;
  for (int y = h / 8; y < h - h / 8; ++y) {  // the rows of the poles are alike everywhere
    const size_t i = size_t(y);
    ll += left[i] * left[i], rr += right[i] * right[i], lr += left[i] * right[i];
  }
  const double least = kSeamTexture * kSeamTexture * 0.75 * h;
  return ll > least && rr > least && lr > kSeamCorrelation * std::sqrt(ll * rr);
}

// Mean differences to the next pixel of the row, and to the next row without their mean: a sky that darkens upwards is no
// texture.
struct Differences {
  double along = 0, across = 0;
};
Differences differences(const ImageF& grey, int y, int next) {
  const int w = grey.width();
  Differences d;
  double mean = 0;
  for (int x = 0; x < w; ++x) mean += (double(grey.at(x, next)) - double(grey.at(x, y))) / w;
  for (int x = 0; x < w; ++x) {
    d.along += std::abs(double(grey.at((x + 1) % w, y)) - double(grey.at(x, y))) / w;
    d.across += std::abs(double(grey.at(x, next)) - double(grey.at(x, y)) - mean) / w;
  }
  return d;
}

// Rows near a pole are small circles around it: along them little changes from pixel to pixel, across them as much as elsewhere.
bool pole_is_stretched(const ImageF& grey, bool top) {
  const int h = grey.height(), rows = std::max(h / 32, 2);
  const auto ratio = [](const Differences& d) { return d.along / std::max(d.across, 1e-9); };
  Differences pole;
  for (int k = 0; k < rows; ++k) {
    const Differences d = top ? differences(grey, k, k + 1) : differences(grey, h - 1 - k, h - 2 - k);
    pole.along += d.along / rows, pole.across += d.across / rows;
  }
  std::vector<double> middle;
  for (int y = h / 4; y < h - h / 4; ++y) middle.push_back(ratio(differences(grey, y, y + 1)));
  return pole.across > kPoleTexture && ratio(pole) < kPoleStretch * upper_median(middle);
}

bool shows_sphere(ImageF picture) {
  if (picture.width() < kLeastWidth || picture.height() < kLeastWidth / 2) return false;
  if (picture.width() > kTestWidth) picture = resized(picture, kTestWidth, kTestWidth / 2);
  const ImageF g = grey(picture);
  return seam_continues(g) && (pole_is_stretched(g, true) || pole_is_stretched(g, false));
}

ImageF rows_of(const ImageF& image, int first, int count) {
  ImageF out(image.width(), count, image.channels());
  std::copy_n(image.pixel(0, first), out.data().size(), out.data().begin());
  return out;
}

}  // namespace

GPano parse_gpano(std::string_view bytes) {
  GPano pano;
  const size_t at = bytes.find(kNameSpace);  // of the declaration xmlns:PREFIX="..."
  if (at == std::string_view::npos) return pano;
  constexpr size_t kLongestPacket = 1 << 16;
  const size_t begin = at < kLongestPacket ? 0 : at - kLongestPacket;
  const std::string_view packet = bytes.substr(begin, at - begin + kLongestPacket), before = bytes.substr(begin, at - begin);
  const size_t colon = before.rfind("xmlns:"), equals = before.rfind('=');
  constexpr size_t kLongestPrefix = 32;
  if (colon == std::string_view::npos || equals == std::string_view::npos || equals <= colon + 6 ||
      equals - colon > kLongestPrefix)
    return pano;
  const std::string prefix = std::string(before.substr(colon + 6, equals - colon - 6)) + ":";
  pano.projection = xmp_value(packet, prefix + "ProjectionType");
  pano.full_width = whole_number(xmp_value(packet, prefix + "FullPanoWidthPixels"));
  pano.full_height = whole_number(xmp_value(packet, prefix + "FullPanoHeightPixels"));
  pano.cropped_width = whole_number(xmp_value(packet, prefix + "CroppedAreaImageWidthPixels"));
  pano.cropped_height = whole_number(xmp_value(packet, prefix + "CroppedAreaImageHeightPixels"));
  return pano;
}

std::string Panorama::sentence() const {
  switch (kind) {
    case PanoramaKind::None:
      return {};
    case PanoramaKind::Sphere:
      return fmt::format("a 360-degree panorama ({}): it is cut into ten views", evidence);
    case PanoramaKind::Partial:
      return fmt::format(
          "a panorama of a part of the sphere ({}): it is read as a photo without a lens model; export all 360 x 180 "
          "degrees, 2:1, to have it cut into views",
          evidence);
    case PanoramaKind::Stereo:
      return fmt::format(
          "a stereo pair of panoramas, one above the other ({}): it is read as a photo; export one eye, 2:1, to have it "
          "cut into views",
          evidence);
  }
  return {};
}

Panorama panorama_of(const GPano& xmp, int width, int height, const std::function<ImageF()>& preview) {
  const bool sphere_size = twice_as_wide(width, height), square = width == height;
  if (!xmp.projection.empty()) {
    const std::string evidence = fmt::format("XMP GPano:ProjectionType {}", xmp.projection);
    const bool cropped = (xmp.full_width > 0 && xmp.cropped_width > 0 && xmp.cropped_width < xmp.full_width) ||
                         (xmp.full_height > 0 && xmp.cropped_height > 0 && xmp.cropped_height < xmp.full_height);
    if (xmp.projection != "equirectangular") return {PanoramaKind::Partial, evidence};
    if (sphere_size && !cropped) return {PanoramaKind::Sphere, evidence};
    if (square && !cropped) return {PanoramaKind::Stereo, evidence};
    return {PanoramaKind::Partial, fmt::format("{}, {} x {} pixels", evidence, width, height)};
  }
  if (!sphere_size && !square) return {};
  const ImageF picture = preview();
  if (shows_lens_circle(picture)) return {};
  const std::string evidence = "left and right edges continue each other, the rows of a pole are stretched";
  if (sphere_size) return shows_sphere(picture) ? Panorama{PanoramaKind::Sphere, "2:1, " + evidence} : Panorama{};
  const int half = picture.height() / 2;
  if (half < 1 || !shows_sphere(rows_of(picture, 0, half)) || !shows_sphere(rows_of(picture, picture.height() - half, half)))
    return {};
  return {PanoramaKind::Stereo, "in both halves " + evidence};
}

}  // namespace vitrine
