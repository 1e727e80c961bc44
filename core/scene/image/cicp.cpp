#include "core/scene/image/color_profile.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "core/foundation/math/color.h"

namespace vitrine {

namespace {

struct Primaries {
  std::string name;
  Chromaticities xy;
};

std::optional<Primaries> primaries_of(unsigned code) {
  constexpr double kD65[] = {0.3127, 0.3290}, kC[] = {0.310, 0.316};
  const auto of = [](const char* name, double rx, double ry, double gx, double gy, double bx, double by, const double* white) {
    return Primaries{name, {rx, ry, gx, gy, bx, by, white[0], white[1]}};
  };
  switch (code) {
    case 1:
      return Primaries{"Rec. 709", kRec709};
    case 4:
      return of("BT.470 M", 0.67, 0.33, 0.21, 0.71, 0.14, 0.08, kC);
    case 5:
      return of("BT.601 (625 lines)", 0.64, 0.33, 0.29, 0.60, 0.15, 0.06, kD65);
    case 6:
    case 7:
      return of("BT.601 (525 lines)", 0.630, 0.340, 0.310, 0.595, 0.155, 0.070, kD65);
    case 8:
      return of("film", 0.681, 0.319, 0.243, 0.692, 0.145, 0.049, kC);
    case 9:
      return of("BT.2020", 0.708, 0.292, 0.170, 0.797, 0.131, 0.046, kD65);
    case 11: {
      constexpr double kTheatre[] = {0.314, 0.351};
      return of("DCI P3", 0.680, 0.320, 0.265, 0.690, 0.150, 0.060, kTheatre);
    }
    case 12:
      return Primaries{"Display P3", kDisplayP3};
    case 22:
      return of("EBU 3213", 0.630, 0.340, 0.295, 0.605, 0.155, 0.077, kD65);
    default:
      return std::nullopt;
  }
}

// Inverse of the camera transfer function (BT.709 and similar).
double from_bt709(double v) {
  constexpr double kAlpha = 1.09929682680944, kBeta = 0.018053968510807;
  return v < 4.5 * kBeta ? v / 4.5 : std::pow((v + kAlpha - 1) / kAlpha, 1 / 0.45);
}

double from_pq(double v) {  // SMPTE ST 2084, relative to the diffuse white
  constexpr double kM1 = 2610.0 / 16384, kM2 = 2523.0 / 32, kC1 = 3424.0 / 4096, kC2 = 2413.0 / 128, kC3 = 2392.0 / 128;
  constexpr double kPeak = 10000, kWhite = 203;
  const double p = std::pow(std::min(v, 1.0), 1 / kM2);
  return kPeak / kWhite * std::pow(std::max(p - kC1, 0.0) / (kC2 - kC3 * p), 1 / kM1);
}

double from_hlg(double v) {  // ARIB STD-B67, scene light relative to that of the 75 % signal
  constexpr double kA = 0.17883277, kB = 1 - 4 * kA;
  const double c = 0.5 - kA * std::log(4 * kA);
  const auto light = [&](double e) { return e <= 0.5 ? e * e / 3 : (std::exp((e - c) / kA) + kB) / 12; };
  return light(std::min(v, 1.0)) / light(0.75);
}

struct Transfer {
  const char* name;
  ColorProfile::Curve curve;  // none: linear
};

std::optional<Transfer> transfer_of(unsigned code) {
  switch (code) {
    case 1:
    case 6:
    case 14:
    case 15:
      return Transfer{"BT.709", from_bt709};
    case 4:
      return Transfer{"gamma 2.2", [](double v) { return std::pow(v, 2.2); }};
    case 5:
      return Transfer{"gamma 2.8", [](double v) { return std::pow(v, 2.8); }};
    case 8:
      return Transfer{"linear", {}};
    case 13:
      return Transfer{"sRGB", [](double v) { return linear_from_srgb(v); }};
    case 16:
      return Transfer{"PQ", from_pq};
    case 17:
      return Transfer{"ST 428-1", [](double v) { return 52.37 / 48 * std::pow(v, 2.6); }};
    case 18:
      return Transfer{"HLG", from_hlg};
    default:
      return std::nullopt;
  }
}

}  // namespace

ColorProfilePtr cicp_profile(const Cicp& cicp) {
  const auto primaries = primaries_of(cicp.primaries);
  const auto transfer = transfer_of(cicp.transfer);
  if (!primaries || !transfer || cicp.matrix != 0 || !cicp.full_range) return nullptr;
  const bool usual = cicp.primaries == 12 && cicp.transfer == 13;  // Display P3 has the curve of sRGB
  return primaries_profile(usual ? primaries->name : fmt::format("{}, {}", primaries->name, transfer->name), primaries->xy,
                           transfer->curve);
}

}  // namespace vitrine
