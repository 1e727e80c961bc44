#include "stages/inspect/gps_finding.h"

#include <cmath>

#include <fmt/format.h>

#include "core/foundation/math/geodesy.h"

namespace vitrine {

namespace {

constexpr size_t kFewest = 4;
constexpr double kUsualError_m = 1.7;  // standard deviation of a coordinate (GPS SPS Performance Standard, 2020)
constexpr double kPrecision = 0.05;    // of a scale, relative

// Root mean square horizontal distance of the positions from their middle.
double spread_m(std::span<const GpsPosition> positions) {
  const LocalFrame frame({positions[0].latitude, positions[0].longitude, 0});
  const double n = double(positions.size());
  Vec3d sum{};
  double squares = 0;
  for (const GpsPosition& p : positions) {
    Vec3d at = frame.local({p.latitude, p.longitude, 0});
    at.z = 0;  // the curvature of the earth
    sum += at, squares += squared_length(at);
  }
  return std::sqrt(std::max(0.0, squares / n - squared_length(sum / n)));
}

}  // namespace

std::optional<Finding> gps_finding(std::span<const PhotoFacts> photos) {
  std::vector<GpsPosition> positions;
  for (const PhotoFacts& p : photos)
    if (p.usable() && p.gps) positions.push_back(*p.gps);
  if (positions.empty()) return std::nullopt;
  const double n = double(positions.size()), spread = spread_m(positions);
  Finding f{.code = "gps_positions",
            .severity = Severity::Note,
            .what = fmt::format("{} of {} photos have GPS coordinates", positions.size(), photos.size()),
            .why = {},
            .hint = "`vitrine export --scale-bar` measures the scale with a known length in two photos",
            .photos = {}};
  if (positions.size() < kFewest)
    f.why = fmt::format("fewer than {} give no scale", kFewest);
  else if (kUsualError_m > kPrecision * spread * std::sqrt(n))
    f.why =
        fmt::format("they spread over {:.1f} m, too little for a scale at the usual error of {:.1f} m", spread, kUsualError_m);
  else
    f.why = fmt::format("they spread over {:.1f} m: scale and north come from them, if they agree with the poses", spread);
  return f;
}

}  // namespace vitrine
