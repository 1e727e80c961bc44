// Image type: interleaved float or 8/16-bit pixels, rows top to bottom. The centre of pixel (0,0) is (0.5, 0.5). Photos and
// radiance are linear Rec.709 (Image<float>, 3 channels) unless the name contains srgb.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vitrine {

template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels, T value = T{})
      : width_(width),
        height_(height),
        channels_(channels),
        data_(static_cast<size_t>(width) * static_cast<size_t>(height) * static_cast<size_t>(channels), value) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  size_t pixel_count() const { return static_cast<size_t>(width_) * static_cast<size_t>(height_); }
  bool empty() const { return data_.empty(); }

  // Index of channel c of pixel (x, y) in data().
  size_t index(int x, int y, int c = 0) const {
    return (static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)) * static_cast<size_t>(channels_) +
           static_cast<size_t>(c);
  }
  T& at(int x, int y, int c = 0) { return data_[index(x, y, c)]; }
  const T& at(int x, int y, int c = 0) const { return data_[index(x, y, c)]; }
  T* pixel(int x, int y) { return &data_[index(x, y, 0)]; }
  const T* pixel(int x, int y) const { return &data_[index(x, y, 0)]; }
  std::span<T> data() { return data_; }  // [h * w * c]
  std::span<const T> data() const { return data_; }
  bool operator==(const Image&) const = default;

 private:
  int width_ = 0, height_ = 0, channels_ = 0;
  std::vector<T> data_;
};

using ImageF = Image<float>;
using Image8 = Image<uint8_t>;
using Image16 = Image<uint16_t>;

}  // namespace vitrine
