#include "core/image/ldr.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/image/codecs.h"
#include "core/image/jpeg.h"
#include "core/image/png.h"
#include "core/image/probe.h"
#include "core/image/segments.h"
#include "core/math/color.h"

namespace vitrine {

namespace {

constexpr size_t kMaxPixels = size_t(1) << 28, kMaxBytes = size_t(1) << 30;

[[noreturn]] void bad_image(const fs::path& path, std::string why) {
  throw Error(ErrorKind::Input, "cannot read an image",
              {.where = path.string(), .why = std::move(why), .hint = "remove or replace this file", .code = "BAD_IMAGE"});
}

// OpenCV repairs truncated JPEG files in silence; a JPEG without its end marker lost a part of its picture.
bool truncated_jpeg(const std::string& bytes) {
  if (bytes.size() < 4 || uint8_t(bytes[0]) != 0xff || uint8_t(bytes[1]) != 0xd8) return false;
  constexpr size_t kTrailerBytes = 1 << 16;  // cameras append maker data behind the end marker
  return bytes.rfind("\xff\xd9") == std::string::npos || bytes.size() - bytes.rfind("\xff\xd9") > kTrailerBytes;
}

cv::Mat decode(const fs::path& path, int flags) {
  std::string bytes = read_file(path);
  if (bytes.empty()) bad_image(path, "the file is empty");
  if (bytes.size() > kMaxBytes) bad_image(path, fmt::format("a picture of {} bytes is too large", bytes.size()));
  if (const std::string why = implausible_size(probe_photo(bytes), bytes.size()); !why.empty()) bad_image(path, why);
  if (truncated_jpeg(bytes)) bad_image(path, "the JPEG data ends early: the file is truncated");
  if (probe_photo(bytes).format == PhotoFormat::Png) bytes = png_pixels(bytes);
  cv::Mat mat;
  if (const std::string why = codecs().decode(bytes, flags | cv::IMREAD_IGNORE_ORIENTATION, mat); !why.empty())
    bad_image(path, why);
  if (mat.empty()) bad_image(path, "it is damaged, or not a JPEG, PNG or TIFF");
  if (mat.total() > kMaxPixels) bad_image(path, fmt::format("{} x {} pixels are too many", mat.cols, mat.rows));
  return mat;
}

float full_scale(const cv::Mat& mat, const fs::path& path) {
  switch (mat.depth()) {
    case CV_8U:
      return 255.f;
    case CV_16U:
      return 65535.f;
    case CV_32F:
      return 1.f;
  }
  bad_image(path, "its sample type is neither 8 nor 16 bit nor float");
}

}  // namespace

ImageF read_unchanged(const fs::path& path) {
  const cv::Mat mat = decode(path, cv::IMREAD_UNCHANGED);
  const int channels = mat.channels();
  cv::Mat scaled;
  mat.convertTo(scaled, CV_32F, 1.0 / full_scale(mat, path));
  ImageF image(mat.cols, mat.rows, channels);
  for (int y = 0; y < mat.rows; ++y) {
    const float* source = scaled.ptr<float>(y);
    for (int x = 0; x < mat.cols; ++x)
      for (int c = 0; c < channels; ++c) {
        const int from = channels >= 3 && c < 3 ? 2 - c : c;  // OpenCV stores B, G, R
        image.at(x, y, c) = source[x * channels + from];
      }
  }
  return image;
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
  const int flags[] = {cv::IMREAD_COLOR, cv::IMREAD_REDUCED_COLOR_2, cv::IMREAD_REDUCED_COLOR_4, cv::IMREAD_REDUCED_COLOR_8};
  cv::Mat mat = decode(path, flags[reduction == 1 ? 0 : reduction == 2 ? 1 : reduction == 4 ? 2 : 3]);
  cv::cvtColor(mat, mat, cv::COLOR_BGR2RGB);
  Image8 image(mat.cols, mat.rows, 3);
  for (int y = 0; y < mat.rows; ++y) std::copy_n(mat.ptr<uint8_t>(y), 3 * size_t(mat.cols), image.pixel(0, y));
  return image;
}

Image8 read_grey8(const fs::path& path) {
  const cv::Mat mat = decode(path, cv::IMREAD_GRAYSCALE);
  Image8 image(mat.cols, mat.rows, 1);
  for (int y = 0; y < mat.rows; ++y) std::copy_n(mat.ptr<uint8_t>(y), mat.cols, image.pixel(0, y));
  return image;
}

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
