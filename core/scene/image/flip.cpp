// LDR-FLIP (metrics.h): filters of the eye, then colours and features of both pictures.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/vec.h"
#include "core/scene/image/metrics.h"

namespace vitrine {
namespace {

using std::numbers::pi;

using Plane = std::vector<double>;  // one value per pixel, row by row

struct Size {
  int width = 0, height = 0;
  size_t pixels() const { return size_t(width) * size_t(height); }
};

// Weights at offsets -radius .. radius.
using Kernel = std::vector<double>;

// Correlation along x with `across`, then along y with `down`; edges are replicated.
Plane filtered(const Plane& in, Size size, const Kernel& across, const Kernel& down) {
  const size_t width = size_t(size.width);
  Plane rows(in.size()), out(in.size());
  parallel_for(size_t(size.height), 16, [&](size_t y) {
    const size_t radius = across.size() / 2;
    Plane padded(width + 2 * radius);
    for (size_t x = 0; x < padded.size(); ++x) padded[x] = in[y * width + std::min(width - 1, x - std::min(x, radius))];
    for (size_t k = 0; k < across.size(); ++k)
      for (size_t x = 0; x < width; ++x) rows[y * width + x] += across[k] * padded[x + k];
  });
  parallel_for(size_t(size.height), 16, [&](size_t y) {
    const int radius = int(down.size() / 2);
    for (int k = -radius; k <= radius; ++k) {
      const size_t from = size_t(std::clamp(int(y) + k, 0, size.height - 1));
      for (size_t x = 0; x < width; ++x) out[y * width + x] += down[size_t(k + radius)] * rows[from * width + x];
    }
  });
  return out;
}

// --- colours -------------------------------------------------------------------------------------------------------

// Linear Rec. 709 to XYZ, columns; white, (0.95043, 1, 1.08890), is D65.
constexpr Mat3d kXyzFromRgb{{0.4123865632529917, 0.2126368216773238, 0.0193306201524840},
                            {0.3575914909206254, 0.7151829818412507, 0.1191971636402082},
                            {0.1804504912035637, 0.0721801964814254, 0.9503725870054354}};

Vec3d relative_to_white(const Vec3d& rgb) {
  const Vec3d white = kXyzFromRgb * Vec3d{1, 1, 1}, xyz = kXyzFromRgb * rgb;
  return {xyz.x / white.x, xyz.y / white.y, xyz.z / white.z};
}

// YCxCz: CIELAB with the identity in place of its cube root, linear in the light.
Vec3d ycxcz_from_rgb(const Vec3d& rgb) {
  const Vec3d w = relative_to_white(rgb);
  return {116 * w.y - 16, 500 * (w.x - w.y), 200 * (w.y - w.z)};
}

Vec3d rgb_from_ycxcz(const Vec3d& c) {
  const Mat3d& m = kXyzFromRgb;
  const Vec3d white = m * Vec3d{1, 1, 1};
  const double y = (c.x + 16) / 116;
  const Vec3d xyz{(y + c.y / 500) * white.x, y * white.y, (y - c.z / 200) * white.z};
  return Vec3d{dot(cross(m.c1, m.c2), xyz), dot(cross(m.c2, m.c0), xyz), dot(cross(m.c0, m.c1), xyz)} / determinant(m);
}

// CIELAB, a and b multiplied by 0.01 L: differences of dark colours look less colourful (Hunt).
Vec3d hunt_lab_from_rgb(const Vec3d& rgb) {
  constexpr double kDelta = 6.0 / 29;
  const auto f = [](double t) { return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29; };
  const Vec3d w = relative_to_white(rgb);
  const double l = 116 * f(w.y) - 16;
  return {l, 0.01 * l * 500 * (f(w.x) - f(w.y)), 0.01 * l * 200 * (f(w.y) - f(w.z))};
}

// HyAB distance to the power 0.7.
double compressed_distance(const Vec3d& a, const Vec3d& b) {
  return std::pow(std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z), 0.7);
}

// The distance of green and blue, the largest in sRGB, becomes 1; the lower 40 % of the distances take 95 % of the range.
double colour_error(const Vec3d& a, const Vec3d& b) {
  static const double largest = compressed_distance(hunt_lab_from_rgb({0, 1, 0}), hunt_lab_from_rgb({0, 0, 1}));
  constexpr double kKnee = 0.4, kAtKnee = 0.95;
  const double share = compressed_distance(a, b) / largest;
  return share < kKnee ? kAtKnee / kKnee * share : kAtKnee + (share - kKnee) / (1 - kKnee) * (1 - kAtKnee);
}

// --- contrast sensitivity ------------------------------------------------------------------------------------------

// Sum of two Gaussians in degrees: a sqrt(pi / b) exp(-pi^2 x^2 / b), of the channels Y, Cx, Cz.
struct Sensitivity {
  double a[2], b[2];
};
constexpr Sensitivity kSensitivity[3] = {{{1, 0}, {0.0047, 1e-5}}, {{1, 0}, {0.0053, 1e-5}}, {{34.1, 13.5}, {0.04, 0.025}}};

Plane seen_by_the_eye(const Plane& channel, Size size, const Sensitivity& s, double pixels_per_degree) {
  const int radius = int(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * pixels_per_degree));  // of the widest: blue - yellow
  Plane out(channel.size());
  double total = 0;
  for (int term = 0; term < 2; ++term) {
    if (s.a[term] == 0) continue;
    Kernel kernel(size_t(2 * radius + 1));
    double sum = 0;
    for (int k = -radius; k <= radius; ++k) {
      const double degrees = k / pixels_per_degree;
      sum += kernel[size_t(k + radius)] = std::exp(-pi * pi * degrees * degrees / s.b[term]);
    }
    const double amplitude = s.a[term] * std::sqrt(pi / s.b[term]);
    const Plane part = filtered(channel, size, kernel, kernel);
    for (size_t i = 0; i < out.size(); ++i) out[i] += amplitude * part[i];
    total += amplitude * sum * sum;
  }
  for (double& v : out) v /= total;
  return out;
}

// --- edges and points ----------------------------------------------------------------------------------------------

// Largest difference of the strength of edges and of points in the luminance, to the power 1/2.
Plane feature_error(const Plane& luminance, const Plane& reference, Size size, double pixels_per_degree) {
  constexpr double kWidthDegrees = 0.082;  // of the edges and points that the eye detects
  const double sigma = 0.5 * kWidthDegrees * pixels_per_degree;
  const int radius = int(std::ceil(3 * sigma));
  Kernel smooth, edge, point;
  for (int k = -radius; k <= radius; ++k) {
    const double g = std::exp(-k * k / (2 * sigma * sigma));
    smooth.push_back(g), edge.push_back(-k * g), point.push_back((k * k / (sigma * sigma) - 1) * g);
  }
  // Positive weights sum to 1, negative ones to -1.
  const auto normalise = [](Kernel& kernel, bool derivative) {
    double positive = 0, negative = 0;
    for (double w : kernel) (w > 0 ? positive : negative) += std::abs(w);
    for (double& w : kernel) w /= w > 0 || !derivative ? positive : negative;
  };
  normalise(smooth, false), normalise(edge, true), normalise(point, true);
  const auto strength = [&](const Plane& of, const Kernel& detector) {
    Plane x = filtered(of, size, detector, smooth);
    const Plane y = filtered(of, size, smooth, detector);
    for (size_t i = 0; i < x.size(); ++i) x[i] = std::hypot(x[i], y[i]);
    return x;
  };
  const Plane edges = strength(luminance, edge), points = strength(luminance, point);
  const Plane reference_edges = strength(reference, edge), reference_points = strength(reference, point);
  Plane out(luminance.size());
  for (size_t i = 0; i < out.size(); ++i) {
    const double difference = std::max(std::abs(edges[i] - reference_edges[i]), std::abs(points[i] - reference_points[i]));
    out[i] = std::sqrt(std::min(1.0, difference / std::numbers::sqrt2));
  }
  return out;
}

// What both halves of the measure need of a picture.
struct Seen {
  std::vector<Vec3d> lab;  // filtered, Hunt-adjusted
  Plane luminance;         // as displayed, white = 1
};

Seen seen(const ImageF& srgb, double pixels_per_degree) {
  const Size size{srgb.width(), srgb.height()};
  Plane channels[3];
  for (Plane& c : channels) c.resize(size.pixels());
  Seen out{std::vector<Vec3d>(size.pixels()), Plane(size.pixels())};
  for (size_t i = 0; i < size.pixels(); ++i) {
    const float* const p = &srgb.data()[3 * i];
    const auto linear = [](float v) { return linear_from_srgb(std::clamp(double(v), 0.0, 1.0)); };
    const Vec3d c = ycxcz_from_rgb({linear(p[0]), linear(p[1]), linear(p[2])});
    channels[0][i] = c.x, channels[1][i] = c.y, channels[2][i] = c.z;
    out.luminance[i] = (c.x + 16) / 116;
  }
  for (int c = 0; c < 3; ++c) channels[c] = seen_by_the_eye(channels[c], size, kSensitivity[c], pixels_per_degree);
  for (size_t i = 0; i < size.pixels(); ++i) {
    const Vec3d rgb = rgb_from_ycxcz({channels[0][i], channels[1][i], channels[2][i]});
    out.lab[i] = hunt_lab_from_rgb({std::clamp(rgb.x, 0.0, 1.0), std::clamp(rgb.y, 0.0, 1.0), std::clamp(rgb.z, 0.0, 1.0)});
  }
  return out;
}

}  // namespace

ImageF flip_map(const ImageF& srgb, const ImageF& reference_srgb, double pixels_per_degree) {
  VITRINE_CHECK(srgb.width() == reference_srgb.width() && srgb.height() == reference_srgb.height(), "images of {}x{} and {}x{}",
                srgb.width(), srgb.height(), reference_srgb.width(), reference_srgb.height());
  VITRINE_CHECK(srgb.channels() == 3 && reference_srgb.channels() == 3 && pixels_per_degree > 0, "FLIP of {} and {} channels",
                srgb.channels(), reference_srgb.channels());
  const Seen a = seen(srgb, pixels_per_degree), b = seen(reference_srgb, pixels_per_degree);
  const Plane features = feature_error(a.luminance, b.luminance, {srgb.width(), srgb.height()}, pixels_per_degree);
  ImageF out(srgb.width(), srgb.height(), 1);
  for (size_t i = 0; i < out.pixel_count(); ++i)
    out.data()[i] = float(std::pow(colour_error(a.lab[i], b.lab[i]), 1 - features[i]));
  return out;
}

double flip(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask, double pixels_per_degree) {
  const ImageF map = flip_map(srgb, reference_srgb, pixels_per_degree);
  VITRINE_CHECK(!mask || (mask->width() == map.width() && mask->height() == map.height() && mask->channels() == 1),
                "mask size differs");
  double sum = 0, weight = 0;
  for (size_t i = 0; i < map.pixel_count(); ++i) {
    const double w = mask ? mask->data()[i] : 1.0;
    sum += w * map.data()[i], weight += w;
  }
  return weight > 0 ? sum / weight : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace vitrine
