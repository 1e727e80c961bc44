// Conversion of file colours to linear Rec. 709 (D65), the working space:
//   linear = M curve(encoded)
// with one curve per channel and one matrix M (primaries; Bradford adaptation if the white point differs), or a Little CMS
// transform for table-based profiles. Values outside 0..1 are kept: a saturated red of Display P3 has a negative green in Rec.
// 709.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/image/image.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

// CIE xy of the primaries and the white point.
struct Chromaticities {
  double red_x = 0, red_y = 0, green_x = 0, green_y = 0, blue_x = 0, blue_y = 0, white_x = 0, white_y = 0;
};
inline constexpr Chromaticities kRec709{0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};
inline constexpr Chromaticities kDisplayP3{0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.3127, 0.3290};
inline constexpr Chromaticities kAdobeRgb{0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.3290};
inline constexpr Chromaticities kProPhoto{0.7347, 0.2653, 0.1596, 0.8404, 0.0366, 0.0001, 0.3457, 0.3585};

std::string primaries_name(const Chromaticities& c);  // "Rec. 2020", "ACEScg", or the numbers

// RGB to XYZ (D50, the ICC profile connection space). Not finite for impossible primaries.
Mat3d xyz_d50_from(const Chromaticities& c);
Mat3d rec709_from_xyz_d50();

class ColorProfile {
 public:
  using Curve = std::function<double(double)>;                                // encoded -> linear, for values >= 0
  using PixelFunction = std::function<void(const float*, float*, unsigned)>;  // [n, 3] -> [n, 3], thread-safe

  // Empty `curves`: values are already linear. Well-known spaces get their usual name instead of `name`.
  ColorProfile(std::string name, const std::vector<Curve>& curves, const Mat3d& rec709_from_rgb);
  ColorProfile(std::string name, PixelFunction to_linear);

  const std::string& name() const { return name_; }  // "sRGB", "Display P3", "linear Rec. 709"
  bool is_srgb() const { return kind_ == Kind::Srgb; }
  bool has_rec709_primaries() const { return kind_ == Kind::Srgb || kind_ == Kind::Rec709; }

  bool is_finite() const;  // false: the curves produce NaN or infinity

  // [h, w, 3], 8 or 16 bit samples divided by 255 or 65535. sRGB is decoded exactly with a table of all 65536 values.
  void to_linear(ImageF& image) const;
  // Same for finite floating-point samples, which may be outside 0..1.
  void float_to_linear(ImageF& image) const;

 private:
  enum class Kind { Srgb, Rec709, Matrix, Function };
  void multiply(float* rgb, size_t pixels) const;

  std::string name_;
  Kind kind_ = Kind::Matrix;
  std::vector<Curve> curves_;                          // none, or 3
  std::array<std::vector<float>, 3> tables_;           // [65536] sampled curves; empty if equal to the first
  std::array<float, 9> m_{1, 0, 0, 0, 1, 0, 0, 0, 1};  // rows
  PixelFunction function_;
};

using ColorProfilePtr = std::shared_ptr<const ColorProfile>;
ColorProfilePtr srgb_profile();
ColorProfilePtr linear_rec709_profile();
ColorProfilePtr adobe_rgb_profile();  // Adobe RGB (1998): gamma 563 / 256
// Returns nullptr for impossible primaries.
ColorProfilePtr primaries_profile(std::string name, const Chromaticities& primaries, const ColorProfile::Curve& curve = {});

// Coding-independent code points (ITU-T H.273): primaries and transfer curve of an image. Stored in the cICP chunk of PNG and
// in the ICC profile of HDR images.
struct Cicp {
  unsigned primaries = 2, transfer = 2, matrix = 0;  // 2 = unspecified
  bool full_range = true;
  bool is_hdr() const { return transfer == 16 || transfer == 18; }  // PQ, HLG
};

// nullptr for code points that do not apply to still images. HDR: 1 is the diffuse white of ITU-R BT.2408 (203 cd/m2 of PQ, 75
// % of HLG).
ColorProfilePtr cicp_profile(const Cicp& cicp);

// ICC profiles (versions 2 and 4; matrix, grey curve, table) through Little CMS; only icc.cpp includes its headers. Relative
// colorimetric, no black point compensation, unbounded floating point.
struct IccProfile {
  ColorProfilePtr profile;  // nullptr if unusable
  std::string problem;      // reason if unusable
  bool grey = false;        // for one-channel images
  bool cmyk = false;        // print profile: `profile` is nullptr
};

// Does not throw for damaged bytes. Profiles are cached, because many photos share one.
IccProfile icc_profile(std::string_view bytes);

// EXR colour space: linear, primaries from the attribute "chromaticities", Rec. 709 by default.
struct ExrPrimaries {
  ColorProfilePtr profile = linear_rec709_profile();
  bool stated = false;  // attribute present
  std::string problem;  // reason why the attribute is not used
};

// `bytes`: the file, or its beginning including the header.
ExrPrimaries exr_primaries(std::string_view bytes);

}  // namespace vitrine
