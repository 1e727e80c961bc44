#include "stages/sfm/gps_frame.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/connected_components.h"
#include "core/foundation/math/median.h"
#include "stages/sfm/similarity_fit.h"

namespace vitrine {

static_assert(EIGEN_MAX_ALIGN_BYTES == 16 && EIGEN_MALLOC_ALREADY_ALIGNED == 1, "as in Ceres, see gains/CMakeLists.txt");

namespace {

constexpr size_t kFewest = 4;          // spots that must agree: a similarity always fits two, and nearly always three
constexpr double kOneSpot_m = 0.05;    // receivers repeat a position exactly until they have the next one
constexpr double kOneSpot_rel = 0.01;  // of the median distance of the cameras: photos taken from one place
constexpr double kLine = 0.05;         // width over length of positions on one line
constexpr double kWorst_m = 20;        // stated errors above it are those of radio cells, not of satellites
constexpr double kPrecision = 0.05;    // relative error of the scale, and of the heading in radians
constexpr double kLeastError_m = 0.3;  // positions minutes apart share errors that their residuals do not show
constexpr uint32_t kHypotheses = 500;  // of each kind

double median_of(std::vector<double> values) { return upper_median(std::move(values)); }

Geodetic median_place(std::span<const GpsSighting> sightings, bool& altitude_known) {
  std::vector<double> latitudes, longitudes, altitudes;
  const double first = sightings[0].gps.longitude;
  for (const GpsSighting& s : sightings) {
    latitudes.push_back(s.gps.latitude);
    longitudes.push_back(first + std::remainder(s.gps.longitude - first, 360.0));  // continuous at 180 degrees
    if (s.gps.altitude) altitudes.push_back(*s.gps.altitude);
  }
  altitude_known = !altitudes.empty();
  return {median_of(std::move(latitudes)), std::remainder(median_of(std::move(longitudes)), 360.0),
          altitude_known ? median_of(std::move(altitudes)) : 0};
}

std::vector<SpotPair> pairs_of(std::span<const GpsSighting> sightings, const LocalFrame& frame) {
  std::vector<SpotPair> out;
  for (const GpsSighting& s : sightings)
    out.push_back({s.centre, frame.local({s.gps.latitude, s.gps.longitude, s.gps.altitude.value_or(frame.origin().altitude)}),
                   s.gps.altitude.has_value(), std::max(kReach_m, s.gps.error_m.value_or(0))});
  return out;
}

// Photos of one spot, by their coordinates or by their cameras, become one pair of means.
std::vector<SpotPair> merged_spots(const std::vector<SpotPair>& pairs) {
  Vec3d mean{};
  for (const SpotPair& p : pairs) mean += p.from / double(pairs.size());
  std::vector<double> distances;
  for (const SpotPair& p : pairs) distances.push_back(length(p.from - mean));
  const double near = kOneSpot_rel * median_of(std::move(distances));
  DisjointSets sets(pairs.size());
  for (uint32_t i = 0; i < pairs.size(); ++i)
    for (uint32_t j = 0; j < i; ++j)
      if (std::hypot(pairs[i].to.x - pairs[j].to.x, pairs[i].to.y - pairs[j].to.y) < kOneSpot_m ||
          length(pairs[i].from - pairs[j].from) <= near)
        sets.unite(i, j);
  std::vector<SpotPair> out;
  for (uint32_t root = 0; root < pairs.size(); ++root) {
    if (sets.representative(root) != root) continue;
    SpotPair sum{};
    double count = 0, heights = 0, height = 0, reach = 0;
    for (uint32_t i = root; i < pairs.size(); ++i) {
      if (sets.representative(i) != root) continue;
      sum.from += pairs[i].from, sum.to += pairs[i].to, count += 1, reach = std::max(reach, pairs[i].reach);
      if (pairs[i].height_known) height += pairs[i].to.z, heights += 1;
    }
    out.push_back({sum.from / count, sum.to / count, heights > 0, reach});
    if (heights > 0) out.back().to.z = height / heights;
  }
  return out;
}

// All subsets of two or three spots if they are few, else random ones.
std::vector<std::vector<SpotPair>> samples(const std::vector<SpotPair>& spots, uint32_t size) {
  const auto n = static_cast<uint32_t>(spots.size());
  std::vector<std::vector<SpotPair>> out;
  const uint64_t all = size == 2 ? uint64_t(n) * (n - 1) / 2 : uint64_t(n) * (n - 1) * (n - 2) / 6;
  if (all <= kHypotheses) {
    for (uint32_t i = 0; i < n; ++i)
      for (uint32_t j = 0; j < i; ++j) {
        if (size == 2) out.push_back({spots[i], spots[j]});
        for (uint32_t k = 0; size == 3 && k < j; ++k) out.push_back({spots[i], spots[j], spots[k]});
      }
    return out;
  }
  for (uint32_t h = 0; h < kHypotheses; ++h) {
    Rng rng(size, h);
    const uint32_t i = rng.below(n), j = (i + 1 + rng.below(n - 1)) % n, k = rng.below(n);
    if (size == 2)
      out.push_back({spots[i], spots[j]});
    else if (k != i && k != j)
      out.push_back({spots[i], spots[j], spots[k]});
  }
  return out;
}

std::optional<Similarity> best_similarity(const std::vector<SpotPair>& spots, const UpPrior& up) {
  std::optional<Similarity> best;
  double least = 1e300;
  for (const uint32_t size : {2u, 3u})
    for (const std::vector<SpotPair>& sample : samples(spots, size)) {
      const std::optional<Similarity> start = size == 2 ? similarity_of_two(sample[0], sample[1], up.direction)
                                                        : similarity_of_three(sample[0], sample[1], sample[2]);
      if (!start || truncated_cost(*start, spots, up) >= least) continue;
      const Similarity s = refined(*start, spots, up);
      const double cost = std::min(truncated_cost(s, spots, up), truncated_cost(*start, spots, up));
      best = truncated_cost(s, spots, up) <= cost ? s : *start;
      least = cost;
    }
  return best;
}

// How well the spots that agree determine the similarity.
struct Determined {
  size_t agreeing = 0;
  double error_m = 0;   // of a position, standard deviation by the residuals
  double spread_m = 0;  // root mean square distance from the middle, horizontal
  bool on_a_line = false;

  double precision() const { return error_m / (spread_m * std::sqrt(double(agreeing))); }
};

Determined determined(const Similarity& s, const std::vector<SpotPair>& spots) {
  std::vector<Eigen::Vector2d> at;
  double squares = 0;
  for (const SpotPair& p : spots) {
    if (!agrees(s, p)) continue;
    const Vec3d q = s * p.from;
    at.emplace_back(q.x, q.y);
    squares += std::pow(q.x - p.to.x, 2) + std::pow(q.y - p.to.y, 2);
  }
  Determined d{.agreeing = at.size()};
  if (at.size() < kFewest) return d;
  const double n = double(at.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : at) mean += p / n;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : at) covariance += (p - mean) * (p - mean).transpose() / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  const double width = std::sqrt(std::max(solver.eigenvalues()(0), 0.0)), longest = std::sqrt(solver.eigenvalues()(1));
  d.spread_m = std::hypot(width, longest);
  d.on_a_line = width < kLine * longest;
  // Four of the 2 n numbers are spent on scale, heading and place.
  d.error_m = std::max(std::sqrt(squares / (2 * n - 4)), kLeastError_m);
  return d;
}

// Empty, or the reason against the fit.
std::string objection(const Determined& d, size_t spots, const char* noun) {
  if (d.agreeing < kFewest || 2 * d.agreeing < spots)
    return fmt::format("the positions agree with those of the photos at {} of {} {} only", d.agreeing, spots, noun);
  if (!(d.precision() <= kPrecision))
    return fmt::format(
        "the photos stand too near to each other, {:.1f} m from their middle, for positions with an error of "
        "{:.1f} m",
        d.spread_m, d.error_m);
  return {};
}

UpPrior prior_of(const GpsPriors& priors) {
  constexpr double kDegree = std::numbers::pi / 180, kFixed = 0.05;
  static_assert(size_t(UpMethod::Nadir) == 4);
  constexpr std::array<double, 5> kSigmas{45, 2, 5, 45, 10};  // by method, in degrees; a ring may stand on a slope
  const double sigma = priors.up_chosen ? kFixed : kSigmas[size_t(priors.orientation.method)];
  return {normalized(priors.orientation.up), sigma * kDegree};
}

// The model keeps its unit, which is the metre.
Similarity of_scale_one(const Similarity& s, std::span<const SpotPair> pairs) {
  Vec3d middle{};
  for (const SpotPair& p : pairs) middle += p.from / double(pairs.size());
  return {1, s.rotation, s * middle - s.rotation * middle};
}

}  // namespace

std::vector<GpsSighting> gps_sightings(const ColmapModel& model, std::span<const Photo> photos) {
  std::vector<GpsSighting> out;
  for (const ColmapImage& image : model.images) {
    const auto photo = std::ranges::find(photos, image.name, &Photo::name);
    if (photo != photos.end() && photo->gps) out.push_back({inverse(image.cam_from_world()).translation, *photo->gps});
  }
  return out;
}

std::optional<GpsFit> fitted_gps(std::span<const GpsSighting> all, const GpsPriors& priors) {
  if (all.empty()) return std::nullopt;
  GpsFit fit{.photos = all.size()};
  const auto refuse = [&](std::string why) {
    fit.refused = std::move(why);
    return fit;
  };
  std::vector<GpsSighting> sightings;
  for (const GpsSighting& s : all) {
    if (!s.gps.datum.empty()) return refuse(fmt::format("the coordinates refer to the datum '{}', not to WGS84", s.gps.datum));
    if (!(s.gps.error_m > kWorst_m)) sightings.push_back(s);
  }
  if (sightings.size() < kFewest)
    return refuse(fmt::format("{} photos have coordinates{}, {} are needed", sightings.size(),
                              sightings.size() < all.size() ? fmt::format(" with a stated error below {:.0f} m", kWorst_m) : "",
                              kFewest));
  fit.origin = median_place(sightings, fit.altitude_known);
  const std::vector<SpotPair> pairs = pairs_of(sightings, LocalFrame(fit.origin));
  const std::vector<SpotPair> spots = merged_spots(pairs);
  if (spots.size() < kFewest)
    return refuse(fmt::format("{} photos with coordinates stand on {} {}, {} are needed", pairs.size(), spots.size(),
                              spots.size() == 1 ? "spot" : "different spots", kFewest));
  std::optional<Similarity> s = best_similarity(spots, prior_of(priors));
  if (!s) return refuse("no two photos with coordinates stand apart horizontally");
  const Determined quality = determined(*s, spots);
  if (std::string why = objection(quality, spots.size(), spots.size() == pairs.size() ? "photos" : "spots"); !why.empty())
    return refuse(std::move(why));
  fit.precision = quality.precision(), fit.on_a_line = quality.on_a_line;
  constexpr double kSigmas = 3;
  fit.confirms_metres = priors.given_poses && std::abs(std::log(s->scale)) < kSigmas * fit.precision;
  if (fit.confirms_metres) s = of_scale_one(*s, spots);
  double squares = 0;
  for (const SpotPair& p : pairs) {
    if (!agrees(*s, p)) continue;
    const Vec3d q = *s * p.from;
    ++fit.agreeing;
    squares += std::pow(q.x - p.to.x, 2) + std::pow(q.y - p.to.y, 2);
  }
  fit.rms_m = std::sqrt(squares / double(std::max<size_t>(fit.agreeing, 1)));
  fit.local_from_model = *s;
  return fit;
}

GeoOrigin geo_origin(const GpsFit& fit, const Similarity& scene_from_model) {
  const Geodetic place = LocalFrame(fit.origin).place(fit.local_from_model * (inverse(scene_from_model) * Vec3d{}));
  GeoOrigin geo{.latitude = place.latitude, .longitude = place.longitude};
  if (fit.altitude_known) geo.altitude = place.altitude;
  geo.metres_per_unit = fit.local_from_model.scale / scene_from_model.scale;
  return geo;
}

SceneInfo framed_scene(const ColmapModel& model, Orientation& orientation, std::optional<GpsFit>& fit) {
  SceneInfo scene;
  const bool used = fit && fit->used();
  Vec3d east{};
  if (used) {
    const Mat3d model_from_local = transposed(fit->local_from_model.rotation);
    east = model_from_local.c0, orientation.up = model_from_local.c2;
  }
  scene.scene_from_colmap = scene_from_colmap(model, orientation, east);
  if (used) {
    scene.geo = geo_origin(*fit, scene.scene_from_colmap);
    scene.scale_known = true;
    fit->metres_per_unit = scene.geo->metres_per_unit;
  }
  return scene;
}

std::string gps_text(const GpsFit& fit) {
  if (!fit.used()) return fmt::format("no scale from GPS of {} photos: {}", fit.photos, fit.refused);
  const std::string photos = fmt::format("GPS of {} of {} photos, {:.1f} m rms", fit.agreeing, fit.photos, fit.rms_m);
  return fmt::format("{}: one unit is {:.4g} m{}",
                     fit.confirms_metres ? "given poses in metres, confirmed by " + photos : "scale from " + photos,
                     fit.metres_per_unit, fit.on_a_line ? "; the photos stand on one line, up is theirs" : "");
}

}  // namespace vitrine
