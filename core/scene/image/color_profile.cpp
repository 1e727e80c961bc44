#include "core/scene/image/color_profile.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/parallel.h"
#include "core/scene/image/segments.h"
#include "core/foundation/math/color.h"

namespace vitrine {

namespace {

constexpr size_t kTable = 65536;            // all values of 8 and 16 bit samples are multiples of 1/65535
constexpr Vec3d kD50{0.9642, 1.0, 0.8249};  // as in ICC profiles

// Tolerances for sRGB variants. They differ by rounding: 0.001 in the matrix; one 8-bit step of the curve in the small profiles
// written by web services. The nearest other spaces (gamma 2.2, Rec. 601 primaries) differ ten times as much.
constexpr double kSameMatrix = 0.005, kSameCurve = 1.5 / 255;

Mat3d inverse(const Mat3d& m) {
  const double d = determinant(m);
  return transposed(Mat3d{cross(m.c1, m.c2) / d, cross(m.c2, m.c0) / d, cross(m.c0, m.c1) / d});
}

Mat3d diagonal(const Vec3d& v) { return {{v.x, 0, 0}, {0, v.y, 0}, {0, 0, v.z}}; }

// Bradford adaptation: scales the cone responses to map one white point to the other.
Mat3d adaptation(const Vec3d& from, const Vec3d& to) {
  const Mat3d cones{{0.8951, -0.7502, 0.0389}, {0.2664, 1.7135, -0.0685}, {-0.1614, 0.0367, 1.0296}};
  const Vec3d a = cones * from, b = cones * to;
  return inverse(cones) * diagonal({b.x / a.x, b.y / a.y, b.z / a.z}) * cones;
}

Vec3d xyz(double x, double y) { return {x, y, 1 - x - y}; }

bool same_matrix(const Mat3d& a, const Mat3d& b) {
  for (size_t i = 0; i < 9; ++i)
    if (!(std::abs(a(i / 3, i % 3) - b(i / 3, i % 3)) < kSameMatrix)) return false;
  return true;
}

// Compares perceptually, in sRGB steps.
bool same_curve(const std::vector<float>& table, const ColorProfile::Curve& curve) {
  for (size_t i = 0; i < kTable; i += 257) {
    const double other = curve(double(i) / (kTable - 1));
    if (!(std::abs(srgb_from_linear(double(table[i])) - srgb_from_linear(other)) < kSameCurve)) return false;
  }
  return true;
}

double srgb_curve(double v) { return linear_from_srgb(v); }
double adobe_curve(double v) { return std::pow(v, 563.0 / 256); }
double prophoto_curve(double v) { return std::pow(v, 1.8); }

struct KnownSpace {
  const char* name;
  Chromaticities primaries;
  ColorProfile::Curve curve;
};
const KnownSpace kKnownSpaces[] = {{"Display P3", kDisplayP3, srgb_curve},
                                   {"Adobe RGB (1998)", kAdobeRgb, adobe_curve},
                                   {"ProPhoto RGB", kProPhoto, prophoto_curve}};

const std::vector<float>& srgb_table() {
  static const std::vector<float> table = [] {
    std::vector<float> t(kTable);
    for (size_t i = 0; i < t.size(); ++i) t[i] = static_cast<float>(linear_from_srgb(static_cast<double>(i) / 65535.0));
    return t;
  }();
  return table;
}

// The comparison also rejects NaN, which a mislabelled float file may contain.
size_t index_of(float v) { return v > 0 ? static_cast<size_t>(std::min(v, 1.0f) * 65535.0f + 0.5f) : 0; }

}  // namespace

std::string primaries_name(const Chromaticities& c) {
  const std::pair<const char*, Chromaticities> known[] = {
      {"Rec. 709", kRec709},
      {"P3 (D65)", kDisplayP3},
      {"Adobe RGB", kAdobeRgb},
      {"Rec. 2020", {0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290}},
      {"ACES AP0", {0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767}},
      {"ACEScg", {0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767}},
      {"CIE XYZ", {1, 0, 0, 1, 0, 0, 1.0 / 3, 1.0 / 3}}};
  constexpr double kSame = 0.0015;
  for (const auto& [name, k] : known) {
    const double off[] = {c.red_x - k.red_x,   c.red_y - k.red_y,   c.green_x - k.green_x, c.green_y - k.green_y,
                          c.blue_x - k.blue_x, c.blue_y - k.blue_y, c.white_x - k.white_x, c.white_y - k.white_y};
    bool same = true;
    for (double d : off) same = same && std::abs(d) < kSame;
    if (same) return name;
  }
  return fmt::format("primaries ({:.3f}, {:.3f}) ({:.3f}, {:.3f}) ({:.3f}, {:.3f})", c.red_x, c.red_y, c.green_x, c.green_y,
                     c.blue_x, c.blue_y);
}

Mat3d xyz_d50_from(const Chromaticities& c) {
  const Mat3d directions{xyz(c.red_x, c.red_y), xyz(c.green_x, c.green_y), xyz(c.blue_x, c.blue_y)};
  const Vec3d white = xyz(c.white_x, c.white_y) / c.white_y;
  return adaptation(white, kD50) * directions * diagonal(inverse(directions) * white);
}

Mat3d rec709_from_xyz_d50() {
  static const Mat3d m = inverse(xyz_d50_from(kRec709));
  return m;
}

ColorProfile::ColorProfile(std::string name, const std::vector<Curve>& curves, const Mat3d& rec709_from_rgb)
    : name_(std::move(name)), curves_(curves) {
  if (curves_.size() == 1) curves_.resize(3, curves_[0]);
  for (size_t c = 0; c < curves_.size(); ++c) {
    tables_[c].resize(kTable);
    for (size_t i = 0; i < kTable; ++i) tables_[c][i] = static_cast<float>(curves_[c](double(i) / (kTable - 1)));
  }
  const auto has_curve = [&](const Curve& curve) {
    return !curves_.empty() && std::all_of(tables_.begin(), tables_.end(), [&](const auto& t) { return same_curve(t, curve); });
  };
  if (same_matrix(rec709_from_rgb, Mat3d::identity())) {
    if (curves_.empty()) kind_ = Kind::Rec709, name_ = "linear Rec. 709";
    if (has_curve(srgb_curve)) {
      kind_ = Kind::Srgb, name_ = "sRGB", tables_ = {};
      return;  // uses its own table
    }
  }
  for (const KnownSpace& known : kKnownSpaces)
    if (same_matrix(rec709_from_rgb, rec709_from_xyz_d50() * xyz_d50_from(known.primaries)) && has_curve(known.curve))
      name_ = known.name;
  for (size_t c = 1; c < 3; ++c)
    if (tables_[c] == tables_[0]) tables_[c].clear();
  for (size_t i = 0; i < 9; ++i) m_[i] = static_cast<float>(rec709_from_rgb(i / 3, i % 3));
}

ColorProfile::ColorProfile(std::string name, PixelFunction to_linear)
    : name_(std::move(name)), kind_(Kind::Function), function_(std::move(to_linear)) {}

bool ColorProfile::is_finite() const {
  constexpr float kLargest = 1000;
  for (const auto& table : tables_)
    for (float v : table)
      if (!(std::abs(v) < kLargest)) return false;
  return true;
}

void ColorProfile::multiply(float* rgb, size_t pixels) const {
  const std::array<float, 9> m = m_;
  for (size_t i = 0; i < pixels; ++i, rgb += 3) {
    const float r = rgb[0], g = rgb[1], b = rgb[2];
    rgb[0] = m[0] * r + m[1] * g + m[2] * b;
    rgb[1] = m[3] * r + m[4] * g + m[5] * b;
    rgb[2] = m[6] * r + m[7] * g + m[8] * b;
  }
}

namespace {

constexpr size_t kChunk = 1 << 14;      // pixels
constexpr double kHighestValue = 65504.0;  // far above 1, outside the intended domain of the curves

}  // namespace

void ColorProfile::to_linear(ImageF& image) const {
  if (kind_ == Kind::Srgb) {
    const std::vector<float>& table = srgb_table();
    for (float& v : image.data()) v = v > 0 ? table[index_of(v)] : 0.0f;
    return;
  }
  if (kind_ == Kind::Function || curves_.empty()) {
    float_to_linear(image);
    return;
  }
  const float* const red = tables_[0].data();
  const float* const green = tables_[1].empty() ? red : tables_[1].data();
  const float* const blue = tables_[2].empty() ? red : tables_[2].data();
  parallel_chunks(image.pixel_count(), kChunk, [&](size_t, size_t begin, size_t end) {
    float* p = image.data().data() + 3 * begin;
    for (size_t i = 0; i < end - begin; ++i) {
      p[3 * i] = red[index_of(p[3 * i])];
      p[3 * i + 1] = green[index_of(p[3 * i + 1])];
      p[3 * i + 2] = blue[index_of(p[3 * i + 2])];
    }
    multiply(p, end - begin);
  });
}

void ColorProfile::float_to_linear(ImageF& image) const {
  if (kind_ == Kind::Rec709) return;
  parallel_chunks(image.pixel_count(), kChunk, [&](size_t, size_t begin, size_t end) {
    float* const p = image.data().data() + 3 * begin;
    if (kind_ == Kind::Function) {
      std::vector<float> from(p, p + 3 * (end - begin));
      function_(from.data(), p, static_cast<unsigned>(end - begin));
      return;
    }
    for (size_t i = 0; !curves_.empty() && i < 3 * (end - begin); ++i) {
      const double v = p[i], linear = kind_ == Kind::Srgb ? linear_from_srgb(std::abs(v)) : curves_[i % 3](std::abs(v));
      p[i] = static_cast<float>(v < 0 ? -std::min(linear, kHighestValue) : std::min(linear, kHighestValue));
    }
    if (kind_ != Kind::Srgb) multiply(p, end - begin);
  });
}

ColorProfilePtr srgb_profile() {
  static const ColorProfilePtr p =
      std::make_shared<ColorProfile>("sRGB", std::vector<ColorProfile::Curve>{srgb_curve}, Mat3d::identity());
  return p;
}

ColorProfilePtr linear_rec709_profile() {
  static const ColorProfilePtr p =
      std::make_shared<ColorProfile>("linear Rec. 709", std::vector<ColorProfile::Curve>{}, Mat3d::identity());
  return p;
}

ColorProfilePtr adobe_rgb_profile() {
  static const ColorProfilePtr p = primaries_profile("Adobe RGB (1998)", kAdobeRgb, adobe_curve);
  return p;
}

ColorProfilePtr primaries_profile(std::string name, const Chromaticities& primaries, const ColorProfile::Curve& curve) {
  constexpr double kLargest = 100;  // maximum matrix element of real primaries; ACES AP0 has 2.5
  if (!(primaries.white_y > 0)) return nullptr;
  const Mat3d m = rec709_from_xyz_d50() * xyz_d50_from(primaries);
  for (size_t i = 0; i < 9; ++i)
    if (!(std::abs(m(i / 3, i % 3)) < kLargest)) return nullptr;
  if (!(std::abs(determinant(m)) > 1 / kLargest)) return nullptr;
  return std::make_shared<ColorProfile>(std::move(name), curve ? std::vector{curve} : std::vector<ColorProfile::Curve>{}, m);
}

ExrPrimaries exr_primaries(std::string_view bytes) {
  ExrPrimaries out;
  const std::string_view raw = exr_attribute(bytes, "chromaticities", "chromaticities");
  if (raw.size() != 32) return out;
  double v[8];
  for (size_t i = 0; i < 8; ++i) v[i] = std::bit_cast<float>(static_cast<uint32_t>(number_at(raw, 4 * i, 4, false)));
  const Chromaticities c{v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7]};
  if (ColorProfilePtr profile = primaries_profile("linear " + primaries_name(c), c)) {
    out.profile = std::move(profile);
    out.stated = true;
  } else {
    out.problem = "its chromaticities are impossible";
  }
  return out;
}

}  // namespace vitrine
