// An uncompressed DNG (Adobe DNG 1.4) of a camera whose colours are known: samples of a Bayer sensor that saw given linear
// Rec. 709 colours.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine::test {

struct DngDesc {
  int width = 96, height = 64, orientation = 1;
  std::string make = "Maker", model = "Model R", time = "2026:05:01 10:00:00";
  Vec3d neutral{0, 0, 0};  // as shot: what the camera takes for neutral; 0: the light of the scene, D65
  bool matrix = true;      // ColorMatrix1
  double focal_mm = 8, focal_35mm = 40;
};

inline constexpr unsigned kDngBlack = 256, kDngWhite = 16000;

// Camera from linear Rec. 709: each row is what a channel sees of red, green and blue.
inline Mat3d dng_camera() { return {{0.50, 0.15, 0.05}, {0.30, 0.75, 0.25}, {0.05, 0.10, 0.45}}; }
// What the camera sees of D65, the largest channel 1.
inline Vec3d dng_neutral() {
  const Vec3d v = dng_camera() * Vec3d{1, 1, 1};
  return v / std::max({v.x, v.y, v.z});
}

class DngWriter {
 public:
  void number(std::string& to, uint64_t v, size_t n) {
    for (size_t i = 0; i < n; ++i) to += static_cast<char>(v >> 8 * i);
  }
  void field(unsigned tag, unsigned type, size_t count, std::string values) {
    fields_.push_back({tag, type, count, std::move(values)});
  }
  void shorts(unsigned tag, const std::vector<unsigned>& v) {
    std::string s;
    for (const unsigned n : v) number(s, n, 2);
    field(tag, 3, v.size(), s);
  }
  void longs(unsigned tag, const std::vector<unsigned>& v) {
    std::string s;
    for (const unsigned n : v) number(s, n, 4);
    field(tag, 4, v.size(), s);
  }
  void rationals(unsigned tag, const std::vector<double>& v, bool is_signed = false) {
    std::string s;
    for (const double n : v) number(s, static_cast<uint32_t>(int32_t(std::lround(n * 1e6))), 4), number(s, 1000000, 4);
    field(tag, is_signed ? 10 : 5, v.size(), s);
  }
  void text(unsigned tag, const std::string& s) { field(tag, 2, s.size() + 1, s + '\0'); }
  void bytes(unsigned tag, std::initializer_list<int> v) {
    std::string s;
    for (const int n : v) s += static_cast<char>(n);
    field(tag, 1, s.size(), s);
  }
  // The directory for the offset `at`, and its values behind it.
  std::string directory(size_t at) {
    std::stable_sort(fields_.begin(), fields_.end(), [](const Field& a, const Field& b) { return a.tag < b.tag; });
    std::string out, values;
    number(out, fields_.size(), 2);
    const size_t values_at = at + 2 + 12 * fields_.size() + 4;
    for (const Field& f : fields_) {
      number(out, f.tag, 2), number(out, f.type, 2), number(out, f.count, 4);
      if (f.values.size() <= 4) {
        out += f.values + std::string(4 - f.values.size(), '\0');
      } else {
        number(out, values_at + values.size(), 4);
        values += f.values + std::string(f.values.size() % 2, '\0');
      }
    }
    number(out, 0, 4);
    fields_.clear();
    return out + values;
  }

 private:
  struct Field {
    unsigned tag, type;
    size_t count;
    std::string values;
  };
  std::vector<Field> fields_;
};

// `color`: linear Rec. 709 at a pixel; 1 is where the most sensitive channel saturates.
inline std::string dng_bytes(const DngDesc& d, const std::function<Vec3d(int x, int y)>& color) {
  DngWriter w;
  std::string pixels;
  const Mat3d camera = dng_camera();
  const Vec3d white = camera * Vec3d{1, 1, 1};
  const double largest = std::max({white.x, white.y, white.z});
  for (int y = 0; y < d.height; ++y)
    for (int x = 0; x < d.width; ++x) {
      const Vec3d seen = camera * color(x, y) / largest;
      const double v = (y % 2 == 0 ? (x % 2 == 0 ? seen.x : seen.y) : x % 2 == 0 ? seen.y : seen.z);
      w.number(pixels, unsigned(std::lround(std::clamp(kDngBlack + v * (kDngWhite - kDngBlack), 0.0, double(kDngWhite)))), 2);
    }
  constexpr size_t kPixelsAt = 8;
  const size_t exif_at = kPixelsAt + pixels.size();
  w.rationals(33434, {0.01}), w.rationals(33437, {2.0}), w.shorts(34855, {100}), w.text(36867, d.time);
  w.rationals(37386, {d.focal_mm}), w.shorts(41989, {unsigned(d.focal_35mm)});
  std::string exif = w.directory(exif_at);
  exif += std::string(exif.size() % 2, '\0');
  w.longs(254, {0}), w.longs(256, {unsigned(d.width)}), w.longs(257, {unsigned(d.height)}), w.shorts(258, {16}),
      w.shorts(259, {1});
  w.shorts(262, {32803}), w.text(271, d.make), w.text(272, d.model), w.longs(273, {unsigned(kPixelsAt)});
  w.shorts(274, {unsigned(d.orientation)}), w.shorts(277, {1}), w.longs(278, {unsigned(d.height)});
  w.longs(279, {unsigned(pixels.size())}), w.shorts(284, {1}), w.longs(34665, {unsigned(exif_at)});
  w.shorts(33421, {2, 2}), w.bytes(33422, {0, 1, 1, 2}), w.bytes(50706, {1, 4, 0, 0}), w.bytes(50707, {1, 1, 0, 0});
  w.text(50708, d.make + " " + d.model), w.shorts(50714, {kDngBlack}), w.shorts(50717, {kDngWhite});
  if (d.matrix) {  // camera from XYZ = camera from Rec. 709, and Rec. 709 from XYZ (IEC 61966-2-1)
    const Mat3d rec709{
        {3.2404542, -0.9692660, 0.0556434}, {-1.5371385, 1.8760108, -0.2040259}, {-0.4985314, 0.0415560, 1.0572252}};
    std::vector<double> rows;
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 3; ++c) rows.push_back((camera * rec709.column(c))[r]);
    w.rationals(50721, rows, true);
    w.shorts(50778, {21});
  }
  const Vec3d neutral = d.neutral.y > 0 ? d.neutral : dng_neutral();
  w.rationals(50728, {neutral.x, neutral.y, neutral.z});
  std::string out = "II*";
  out += '\0';
  w.number(out, exif_at + exif.size(), 4);
  return out + pixels + exif + w.directory(exif_at + exif.size());
}

}  // namespace vitrine::test
