#include "core/scene/image/ldr.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/math/color.h"
#include "core/scene/image/codecs.h"
#include "core/scene/image/file_kind.h"
#include "core/scene/image/heif_file.h"
#include "core/scene/image/picture_file.h"
#include "core/scene/image/resample.h"
#include "core/scene/image/tiff_pages.h"

namespace vitrine {

namespace {

constexpr size_t kMaxPixels = size_t(1) << 28, kMaxBytes = size_t(1) << 30;

[[noreturn]] void bad_image(const fs::path& path, std::string why) {
  throw Error(ErrorKind::Input, "cannot read an image",
              {.where = path.string(), .why = std::move(why), .hint = "remove or replace this file", .code = "BAD_IMAGE"});
}

template <class T>
Image<T> rgb_of(const cv::Mat& mat) {
  const int channels = mat.channels();
  Image<T> image(mat.cols, mat.rows, channels);
  for (int y = 0; y < mat.rows; ++y) {
    const T* from = mat.ptr<T>(y);
    T* to = image.pixel(0, y);
    for (int x = 0; x < mat.cols; ++x, from += channels, to += channels)
      for (int c = 0; c < channels; ++c) to[c] = from[channels >= 3 && c < 3 ? 2 - c : c];  // OpenCV order is B, G, R
  }
  return image;
}

AnyImage decode_other(const fs::path& path, const std::string& bytes) {
  cv::Mat mat;
  if (const std::string why = codecs().other(bytes, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION, mat); !why.empty())
    bad_image(path, why);
  if (mat.empty()) bad_image(path, fmt::format("it is {}, but it is damaged", file_kind(bytes).name));
  if (mat.total() > kMaxPixels) bad_image(path, fmt::format("{} x {} pixels are too many", mat.cols, mat.rows));
  switch (mat.depth()) {
    case CV_8U:
      return rgb_of<uint8_t>(mat);
    case CV_16U:
      return rgb_of<uint16_t>(mat);
    case CV_32F:
      return rgb_of<float>(mat);
  }
  bad_image(path, "its sample type is neither 8 nor 16 bit nor float");
}

struct Decoded {
  AnyImage image;
  bool reduced = false;  // the codec already applied the reduction
  int orientation = 1;   // orientation tag of the TIFF page
};

// `channels`: 0 = as in the file, else the number requested from the JPEG decoder, which also applies `reduction`.
Decoded decode(const fs::path& path, int channels = 0, int reduction = 1) {
  const std::string bytes = read_file(path);
  if (bytes.size() > kMaxBytes) bad_image(path, fmt::format("a picture of {} bytes is too large", bytes.size()));
  const PictureFile file = examine_picture(bytes, path.extension().string());
  Decoded decoded{.image = {}, .reduced = false, .orientation = file.probe.orientation};
  if (file.probe.format == PhotoFormat::Unknown && file_kind(bytes).decodable) {
    decoded.image = decode_other(path, bytes);
    return decoded;
  }
  if (!file.refusal.empty()) bad_image(path, file.refusal);
  std::string why;
  switch (file.probe.format) {
    case PhotoFormat::Jpeg: {
      Image8 image;
      if (why = codecs().jpeg(bytes, channels, reduction, image); !why.empty())
        why = fmt::format("the JPEG is damaged ({})", why);
      decoded.image = std::move(image);
      decoded.reduced = true;
      break;
    }
    case PhotoFormat::Png: {
      Image8 narrow;
      Image16 wide;
      if (why = codecs().png(bytes, narrow, wide); !why.empty()) why = fmt::format("the PNG is damaged ({})", why);
      if (wide.empty())
        decoded.image = std::move(narrow);
      else
        decoded.image = std::move(wide);
      break;
    }
    case PhotoFormat::Tiff:
      why = read_tiff(bytes, tiff_pages(bytes), decoded.image);
      break;
    case PhotoFormat::Heif: {
      Image8 narrow;
      Image16 wide;
      why = decoded_heif(bytes, file_kind(bytes).name, narrow, wide);
      if (wide.empty())
        decoded.image = std::move(narrow);
      else
        decoded.image = std::move(wide);
      break;
    }
    case PhotoFormat::Raw:  // photos only (core/intake/photos/raw_photo.h)
      why = is_tiff(bytes) ? tiff_refusal(tiff_pages(bytes)) : foreign_content(bytes, path.extension().string());
      break;
    case PhotoFormat::Exr:
    case PhotoFormat::Unknown:
      why = foreign_content(bytes, path.extension().string());
      break;
  }
  if (!why.empty()) bad_image(path, why);
  return decoded;
}

template <class T>
constexpr float full_scale() {
  return std::is_floating_point_v<T> ? 1.f : float(std::numeric_limits<T>::max());
}

uint8_t byte_of(uint8_t v) { return v; }
uint8_t byte_of(uint16_t v) { return static_cast<uint8_t>((v + 128) / 257); }
uint8_t byte_of(float v) { return v > 0 ? static_cast<uint8_t>(std::min(v, 1.f) * 255.f + 0.5f) : uint8_t(0); }

// Grey is replicated; RGB is converted to grey with ITU-R BT.601 weights; alpha is dropped.
Image8 bytes_of(const AnyImage& any, int channels) {
  return std::visit(
      [&](const auto& image) {
        Image8 out(image.width(), image.height(), channels);
        const int given = image.channels();
        for (size_t i = 0; i < image.pixel_count(); ++i) {
          const auto* const from = &image.data()[i * size_t(given)];
          uint8_t* const to = &out.data()[i * size_t(channels)];
          if (channels == 3)
            for (int c = 0; c < 3; ++c) to[c] = byte_of(from[given >= 3 ? c : 0]);
          else if (given < 3)
            to[0] = byte_of(from[0]);
          else
            to[0] =
                static_cast<uint8_t>((byte_of(from[0]) * 4899 + byte_of(from[1]) * 9617 + byte_of(from[2]) * 1868 + 8192) >> 14);
        }
        return out;
      },
      any);
}

ImageF floats_of(AnyImage&& any) {
  if (auto* const floats = std::get_if<ImageF>(&any)) return std::move(*floats);
  return std::visit(
      [](const auto& image) {
        using T = std::decay_t<decltype(image.data()[0])>;
        constexpr float kScale = 1.f / full_scale<T>();
        ImageF out(image.width(), image.height(), image.channels());
        std::transform(image.data().begin(), image.data().end(), out.data().begin(),
                       [&](T v) { return static_cast<float>(v) * kScale; });
        return out;
      },
      any);
}

}  // namespace

ImageF read_unchanged(const fs::path& path) { return floats_of(decode(path).image); }

ImageF read_as_oriented(const fs::path& path) {
  Decoded decoded = decode(path);
  return upright(floats_of(std::move(decoded.image)), decoded.orientation);
}

ImageF read_srgb(const fs::path& path) {
  ImageF any = read_unchanged(path);
  if (any.channels() == 3) return any;
  ImageF rgb(any.width(), any.height(), 3);
  for (int y = 0; y < any.height(); ++y)
    for (int x = 0; x < any.width(); ++x)
      for (int c = 0; c < 3; ++c) rgb.at(x, y, c) = any.at(x, y, any.channels() >= 3 ? c : 0);
  return rgb;
}

Image8 read_srgb8(const fs::path& path, int reduction) {
  VITRINE_CHECK(reduction == 1 || reduction == 2 || reduction == 4 || reduction == 8, "reduction {}", reduction);
  Decoded decoded = decode(path, 3, reduction);
  if (auto* const whole = std::get_if<Image8>(&decoded.image);
      whole && whole->channels() == 3 && (decoded.reduced || reduction == 1))
    return std::move(*whole);
  Image8 image = bytes_of(decoded.image, 3);
  if (decoded.reduced || reduction == 1) return image;
  Image8 small(std::max(image.width() / reduction, 1), std::max(image.height() / reduction, 1), 3);
  const cv::Mat from(image.height(), image.width(), CV_8UC3, image.data().data());
  cv::Mat to(small.height(), small.width(), CV_8UC3, small.data().data());
  cv::resize(from, to, to.size(), 0, 0, cv::INTER_LINEAR_EXACT);
  return small;
}

Image8 read_grey8(const fs::path& path) { return bytes_of(decode(path, 1).image, 1); }

namespace {

std::string encoded(const std::string& extension, const cv::Mat& mat, const std::vector<int>& parameters) {
  std::string bytes;
  if (const std::string why = codecs().encode(extension, mat, parameters, bytes); !why.empty())
    throw Error(ErrorKind::Internal, "cannot encode an image", {.where = extension, .why = why});
  return bytes;
}

template <class T>
cv::Mat bgr(const Image<T>& image, int type) {
  VITRINE_CHECK(image.channels() == 1 || image.channels() == 3, "{} channels", image.channels());
  cv::Mat mat(image.height(), image.width(), type, const_cast<T*>(image.data().data()));
  if (image.channels() == 1) return mat.clone();
  cv::Mat swapped;
  cv::cvtColor(mat, swapped, cv::COLOR_RGB2BGR);
  return swapped;
}

}  // namespace

void write_ldr(const fs::path& path, const Image8& image, int jpeg_quality) {
  write_file(path, encoded(path.extension().string(), bgr(image, image.channels() == 1 ? CV_8UC1 : CV_8UC3),
                           {cv::IMWRITE_JPEG_QUALITY, jpeg_quality, cv::IMWRITE_PNG_COMPRESSION, 3}));
}

std::string png_bytes(const Image8& image) {
  return encoded(".png", bgr(image, image.channels() == 1 ? CV_8UC1 : CV_8UC3), {cv::IMWRITE_PNG_COMPRESSION, 6});
}

std::string jpeg_bytes(const Image8& image, int quality) {
  return encoded(".jpg", bgr(image, image.channels() == 1 ? CV_8UC1 : CV_8UC3),
                 {cv::IMWRITE_JPEG_QUALITY, quality, cv::IMWRITE_JPEG_OPTIMIZE, 1, cv::IMWRITE_JPEG_PROGRESSIVE, 1});
}

void write_png16(const fs::path& path, const Image16& image) {
  write_file(path, encoded(path.extension().string(), bgr(image, image.channels() == 1 ? CV_16UC1 : CV_16UC3), {}));
}

namespace {

template <class F>
ImageF mapped(const ImageF& image, F&& f) {
  ImageF out(image.width(), image.height(), image.channels());
  std::transform(image.data().begin(), image.data().end(), out.data().begin(), f);
  return out;
}

}  // namespace

ImageF floats_of(const Image8& image) {
  ImageF out(image.width(), image.height(), image.channels());
  std::transform(image.data().begin(), image.data().end(), out.data().begin(), [](uint8_t v) { return float(v) / 255; });
  return out;
}

Image8 bytes_of(const ImageF& image) {
  Image8 out(image.width(), image.height(), image.channels());
  std::transform(image.data().begin(), image.data().end(), out.data().begin(),
                 [](float v) { return uint8_t(std::lround(std::clamp(double(v), 0.0, 1.0) * 255)); });
  return out;
}

Image8 srgb8_from_linear(const ImageF& linear) {
  Image8 out(linear.width(), linear.height(), linear.channels());
  std::transform(linear.data().begin(), linear.data().end(), out.data().begin(),
                 [](float l) { return uint8_t(std::lround(255.f * srgb_from_linear(std::clamp(l, 0.f, 1.f)))); });
  return out;
}

ImageF srgb_from_linear_image(const ImageF& linear) {
  return mapped(linear, [](float l) { return srgb_from_linear(std::max(l, 0.f)); });
}
ImageF linear_from_srgb_image(const ImageF& srgb) {
  return mapped(srgb, [](float s) { return linear_from_srgb(s); });
}

}  // namespace vitrine
