#include "core/observe/stereo/scene_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/quantile.h"
#include "core/observe/stereo/bare_evidence.h"

namespace vitrine {

namespace {

constexpr int kFewStep = 8, kManyStep = 4;  // sampling step in pixels: for all candidates, for the best ones
constexpr int kWallDirections = 72;
// Candidate distances beyond the scene bounds, in extents along the normal: 0 to kFarthest, denser at short range.
constexpr double kFarthest = 3;
constexpr int kWallSteps = 12, kFloorSteps = 24;
constexpr double kMayLieBehind = 0.01;  // share of stereo points allowed behind a plane: stereo errors
constexpr size_t kMostBarePlanes = 6, kFinalists = 4, kFewestPhotos = 3;
constexpr size_t kFewestSamples = 2000;  // a few photos of 160 pixels; fewer samples are not significant
// Refinement: initial steps in radians and extents, halved in every round.
struct Steps {
  double turn, shift;
};
constexpr Steps kCoarse{0.07, 0.1}, kFine{0.017, 0.03}, kPolish{0.05, 0.06};
constexpr int kRefinements = 5, kPolishes = 2;
constexpr double kLeastGain = 0.001, kLeastFloorGain = 0.0003, kLeastRefuted = 0.0002;  // mean over all samples, brightness
constexpr double kMovedBy = 0.25, kTurnedBy = 0.2;          // extents and radians: perturbations that must increase the cost
constexpr double kUpright = 0.94;                           // cosine to +z above which a plane is horizontal
constexpr double kNearlySquare = 0.95, kSquare = 1 - 1e-9;  // cosines
constexpr double kSquareGain = 0.93;  // of the gain: minimum that must remain after snapping to a right angle

struct Wall {
  ScenePlane plane;
  double gain = 0;
};

class BareWallSearch {
 public:
  BareWallSearch(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps, std::span<const ScenePlane> known)
      : few_(photos, maps, kFewStep), many_(photos, maps, kManyStep) {
    for (size_t v = 0; v < photos.size(); ++v)
      if (!maps[v].zdepth.empty()) add_bounded(photos[v].view, maps[v]);
    floor_known_ = std::ranges::any_of(known, &ScenePlane::floor);
    for (const ScenePlane& plane : known)
      if (std::abs(plane.normal.z) > kUpright) {
        up_ = plane.normal.z > 0 ? plane.normal : -plane.normal;
        break;
      }
    across_ = normalized(cross(up_, Vec3d{0, 1, 0}));
    few_least_ = few_.far_costs(), many_least_ = many_.far_costs();
    for (const ScenePlane& plane : known) explain(plane);
    unexplained_ = many_least_;
  }

  std::vector<ScenePlane> run() {
    std::vector<ScenePlane> walls, candidates;
    if (centres_.size() < kFewestPhotos || many_.size() < kFewestSamples) return walls;
    for (int i = 0; i < kWallDirections; ++i) {
      const double phi = 2 * std::numbers::pi * i / kWallDirections;
      add_candidates(std::cos(phi) * across_ + std::sin(phi) * cross(up_, across_), kWallSteps, candidates);
    }
    if (!floor_known_) add_candidates(-up_, kFloorSteps, candidates);
    while (walls.size() < kMostBarePlanes) {
      Wall next = best_of(candidates);
      if (next.gain == 0) break;
      next.plane.floor = is_level(next.plane);
      many_.measure(next.plane, many_least_);
      explain(next.plane);
      walls.push_back(next.plane);
      const Vec3d found = next.plane.normal;
      if (!next.plane.floor)
        for (const Vec3d& n : at_right_angles(found)) add_candidates(n, kWallSteps, candidates);
      // Removes candidates behind it.
      std::erase_if(candidates, [&](const ScenePlane& c) { return dot(c.normal, found) > kNearlySquare; });
    }
    for (int round = 0; round < kPolishes; ++round)
      for (size_t w = 0; w < walls.size(); ++w) polish(w, walls);
    return walls;
  }

 private:
  // Adds the camera centre and samples of the stereo surface.
  void add_bounded(const View& view, const DepthMap& map) {
    centres_.push_back(view.centre_in_world());
    const Rigid world_from_cam = inverse(view.cam_from_world);
    for (int y = kFewStep / 2; y < map.height; y += kFewStep)
      for (int x = kFewStep / 2; x < map.width; x += kFewStep)
        if (const size_t i = map.index(x, y); map.reliable(i))
          surface_.push_back(world_from_cam * (double(map.zdepth[i]) * view.intrinsics.ray(x + 0.5, y + 0.5)));
  }

  // Range of cameras and stereo points along a normal; walls lie beyond `high`.
  struct Bounds {
    double low = 1e300, high = -1e300;
    double extent() const { return high - low; }
  };
  Bounds bounds(const Vec3d& normal) const {
    Bounds b;
    std::vector<double> along;
    for (const Vec3d& p : surface_) along.push_back(dot(normal, p));
    if (!along.empty()) b = {quantile_of(along, kMayLieBehind), quantile_of(along, 1 - kMayLieBehind)};
    for (const Vec3d& c : centres_) b = {std::min(b.low, dot(normal, c)), std::max(b.high, dot(normal, c))};
    return b;
  }

  void add_candidates(const Vec3d& normal, int steps, std::vector<ScenePlane>& candidates) const {
    const Bounds b = bounds(normal);
    for (int i = 0; i < steps; ++i) {
      const double beyond = kFarthest * std::pow(double(i) / (steps - 1), 2);
      candidates.push_back({.normal = normal, .offset = b.high + beyond * b.extent()});
    }
  }

  bool is_level(const ScenePlane& plane) const { return std::abs(dot(plane.normal, up_)) > kUpright; }
  double least_gain(const ScenePlane& plane) const {
    return (is_level(plane) ? kLeastFloorGain : kLeastGain) * double(many_.size());
  }

  std::array<Vec3d, 4> at_right_angles(const Vec3d& normal) const {
    const Vec3d side = cross(up_, normal);
    return {normal, -normal, side, -side};
  }

  void explain(const ScenePlane& plane) {
    for (const auto& [evidence, least] : {std::pair{&few_, &few_least_}, {&many_, &many_least_}}) {
      const std::vector<float> own = evidence->costs(plane);
      for (size_t r = 0; r < own.size(); ++r) (*least)[r] = std::min((*least)[r], own[r]);
    }
  }

  // Rotates about an axis through the plane's point nearest to the origin.
  static ScenePlane turned(ScenePlane plane, const Vec3d& axis, double angle) {
    const Vec3d foot = plane.offset * plane.normal;
    plane.normal = normalized(std::cos(angle) * plane.normal + std::sin(angle) * cross(axis, plane.normal));
    plane.offset = dot(plane.normal, foot);
    return plane;
  }

  static Wall better(const Wall& a, const Wall& b) { return b.gain > a.gain ? b : a; }

  // steps.turn = 0: translation only.
  Wall refined(const ScenePlane& start, const BareEvidence& evidence, std::span<const float> least, Steps steps) const {
    Wall best{start, evidence.gain(start, least)};
    for (int round = 0; round < kRefinements; ++round, steps = {steps.turn / 2, steps.shift / 2})
      for (const double way : {1.0, -1.0}) {
        ScenePlane moved = best.plane;
        moved.offset += way * steps.shift * bounds(moved.normal).extent();
        std::vector<ScenePlane> tried{moved};
        if (steps.turn > 0 && !is_level(best.plane)) tried.push_back(turned(best.plane, up_, way * steps.turn));
        for (const ScenePlane& p : tried)
          if (p.offset >= bounds(p.normal).high) best = better(best, {p, evidence.gain(p, least)});
      }
    return best;
  }

  // Whether moving or rotating the plane increases its cost in every case.
  bool is_distinct(const ScenePlane& plane) const {
    const double moved = kMovedBy * bounds(plane.normal).extent();
    ScenePlane nearer = plane, farther = plane;
    nearer.offset -= moved, farther.offset += moved;
    std::vector<ScenePlane> others{nearer, farther};
    for (const Vec3d& axis : {up_, across_, cross(up_, across_)}) {
      if (is_level(plane) == (axis == up_)) continue;  // walls stay vertical
      for (const double way : {kTurnedBy, -kTurnedBy}) others.push_back(turned(plane, axis, way));
    }
    return many_.refuted(others, plane, many_least_) > kLeastRefuted * double(many_.size());
  }

  // Gain 0: no candidate is accepted.
  Wall best_of(const std::vector<ScenePlane>& candidates) const {
    std::vector<double> gains(candidates.size());
    parallel_for(gains.size(), 8, [&](size_t c) { gains[c] = few_.gain(candidates[c], few_least_); });
    std::vector<uint32_t> order(candidates.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, std::greater<>(), [&](uint32_t c) { return gains[c]; });
    order.resize(std::min(order.size(), kFinalists));
    std::vector<Wall> finalists(order.size());
    parallel_for(order.size(), 1, [&](size_t f) {
      const Wall coarse = refined(candidates[order[f]], few_, few_least_, kCoarse);
      finalists[f] = refined(coarse.plane, many_, many_least_, kFine);
      Wall& wall = finalists[f];
      if (!(wall.gain > least_gain(wall.plane)) || !is_distinct(wall.plane)) wall.gain = 0;
    });
    return *std::ranges::max_element(finalists, {}, &Wall::gain);
  }

  // Refines a wall again, given the others, and snaps it to a right angle with one of them if the gain hardly drops.
  void polish(size_t w, std::vector<ScenePlane>& walls) const {
    std::vector<float> least = unexplained_;
    for (size_t o = 0; o < walls.size(); ++o) {
      if (o == w) continue;
      const std::vector<float> own = many_.costs(without_end(walls[o]));
      for (size_t r = 0; r < own.size(); ++r) least[r] = std::min(least[r], own[r]);
    }
    const Wall best = refined(without_end(walls[w]), many_, least, kPolish);
    Wall chosen = best;
    for (size_t o = 0; o < walls.size() && !walls[w].floor; ++o)
      for (const Vec3d& n : at_right_angles(walls[o].normal)) {
        const double cosine = dot(n, best.plane.normal);
        if (o == w || walls[o].floor || !(cosine > kNearlySquare && cosine < kSquare)) continue;
        ScenePlane square = best.plane;
        square.offset = std::max(bounds(n).high, best.plane.offset * dot(n, best.plane.normal)), square.normal = n;
        const Wall again = refined(square, many_, least, {0, kPolish.shift});
        if (again.gain > kSquareGain * best.gain && (chosen.plane.normal == best.plane.normal || again.gain > chosen.gain))
          chosen = again;
      }
    walls[w] = chosen.plane;
    many_.measure(walls[w], least);
  }

  static ScenePlane without_end(ScenePlane plane) {
    plane.extent = 0;
    return plane;
  }

  BareEvidence few_, many_;
  std::vector<Vec3d> centres_, surface_;
  bool floor_known_ = false;
  Vec3d up_{0, 0, 1}, across_{1, 0, 0};
  std::vector<float> few_least_, many_least_, unexplained_;
};

}  // namespace

std::vector<ScenePlane> bare_walls(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps,
                                   std::span<const ScenePlane> planes) {
  return BareWallSearch(photos, maps, planes).run();
}

}  // namespace vitrine
