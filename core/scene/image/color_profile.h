// The colours of a file as linear Rec. 709 (D65), the space of every picture inside:
//   linear = M curve(encoded)
// with one curve per channel and one matrix M (primaries; Bradford adaptation when the white is another), or, for profiles that
// are tables, a function from Little CMS. Values outside of 0..1 are kept: a saturated red of Display P3 has a negative green in
// Rec. 709.
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

// CIE xy of the primaries and of white.
struct Chromaticities {
  double red_x = 0, red_y = 0, green_x = 0, green_y = 0, blue_x = 0, blue_y = 0, white_x = 0, white_y = 0;
};
inline constexpr Chromaticities kRec709{0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};
inline constexpr Chromaticities kDisplayP3{0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.3127, 0.3290};
inline constexpr Chromaticities kAdobeRgb{0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.3290};
inline constexpr Chromaticities kProPhoto{0.7347, 0.2653, 0.1596, 0.8404, 0.0366, 0.0001, 0.3457, 0.3585};

std::string primaries_name(const Chromaticities& c);  // "Rec. 2020", "ACEScg", or the numbers

// Linear RGB of these primaries as XYZ under D50, the connection space of ICC profiles. Not finite for impossible primaries.
Mat3d xyz_d50_from(const Chromaticities& c);
Mat3d rec709_from_xyz_d50();

class ColorProfile {
 public:
  using Curve = std::function<double(double)>;                                // encoded -> linear, asked for values of 0 and more
  using PixelFunction = std::function<void(const float*, float*, unsigned)>;  // [n, 3] -> [n, 3], callable from several threads

  // `curves` empty: the values are linear already. Well-known spaces get their usual name, whatever `name` calls them.
  ColorProfile(std::string name, const std::vector<Curve>& curves, const Mat3d& rec709_from_rgb);
  ColorProfile(std::string name, PixelFunction to_linear);

  const std::string& name() const { return name_; }  // "sRGB", "Display P3", "linear Rec. 709"
  bool is_srgb() const { return kind_ == Kind::Srgb; }
  bool has_rec709_primaries() const { return kind_ == Kind::Srgb || kind_ == Kind::Rec709; }

  bool is_finite() const;  // false: its curves give numbers that no light has

  // [h, w, 3], values of 8 or 16 bit samples over 255 or 65535. sRGB is decoded exactly, by a table of all 65536 values.
  void to_linear(ImageF& image) const;
  // The same for floating-point samples, which may lie outside of 0..1. They are finite.
  void float_to_linear(ImageF& image) const;

 private:
  enum class Kind { Srgb, Rec709, Matrix, Function };
  void multiply(float* rgb, size_t pixels) const;

  std::string name_;
  Kind kind_ = Kind::Matrix;
  std::vector<Curve> curves_;                          // none, or 3
  std::array<std::vector<float>, 3> tables_;           // [65536] of the curves; one that equals the first is empty
  std::array<float, 9> m_{1, 0, 0, 0, 1, 0, 0, 0, 1};  // rows
  PixelFunction function_;
};

using ColorProfilePtr = std::shared_ptr<const ColorProfile>;
ColorProfilePtr srgb_profile();
ColorProfilePtr linear_rec709_profile();
ColorProfilePtr adobe_rgb_profile();  // Adobe RGB (1998): gamma 563 / 256
// The matrix is checked: nullptr for primaries that no light has.
ColorProfilePtr primaries_profile(std::string name, const Chromaticities& primaries, const ColorProfile::Curve& curve = {});

// Coding-independent code points (ITU-T H.273): four numbers that name the primaries and the curve of a picture. PNG files have
// them in their cICP chunk, HDR pictures in their ICC profile.
struct Cicp {
  unsigned primaries = 2, transfer = 2, matrix = 0;  // 2 = not said
  bool full_range = true;
  bool is_hdr() const { return transfer == 16 || transfer == 18; }  // PQ, HLG
};

// nullptr for code points that name no colours of a still picture. HDR: 1 is the diffuse white of ITU-R BT.2408 (203 cd/m2 of PQ,
// 75 % of HLG).
ColorProfilePtr cicp_profile(const Cicp& cicp);

// ICC profiles (versions 2 and 4; matrices, grey curves, tables) through Little CMS; its headers stay in icc.cpp. Relative
// colorimetric, without black point compensation, in floating point without bounds.
struct IccProfile {
  ColorProfilePtr profile;  // nullptr: it cannot be used
  std::string problem;      // why not
  bool grey = false;        // of pictures of one channel
  bool cmyk = false;        // of print: there is no profile then
};

// Never throws for damaged bytes. One profile that many photos carry is read once.
IccProfile icc_profile(std::string_view bytes);

// What an EXR says of its colours: linear values of the primaries in its attribute "chromaticities", of Rec. 709 without one.
struct ExrPrimaries {
  ColorProfilePtr profile = linear_rec709_profile();
  bool stated = false;  // by the file
  std::string problem;  // why what it states is not used
};

// `bytes`: the file, or as much of its beginning as holds the header.
ExrPrimaries exr_primaries(std::string_view bytes);

}  // namespace vitrine
