#include "stages/masks/proposed/hull_vote.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/camera/projection.h"
#include "core/math/median.h"
#include "core/math/quantile.h"

namespace vitrine {

namespace {

constexpr double kLowShare = 0.02, kHighShare = 0.98, kBoxMargin = 0.1;  // the box: of the sparse points
constexpr double kFarthest = 1.2;  // of the cameras' radius, which is 1: farther out nobody walked around it
constexpr double kHidden = 0.93;   // a voxel farther than the fit's surface by more than this is not seen
constexpr double kVotes = 0.3;     // of the views that see a voxel: so many must have an opinion
constexpr size_t kFewestVotes = 5;
constexpr double kQuantile = 0.4;      // three views in five agree that something deviates there
constexpr size_t kSmallestThing = 30;  // voxels
constexpr double kStrongRatio = 1.8;   // of the smallest deviations that count
constexpr double kStrongShare = 0.05;  // of a thing's voxels
constexpr size_t kFewestVoxels = 500;  // with a score; fewer are no scene that was walked around
constexpr double kSeeThrough = 0.6;
constexpr double kNormalQuartile = 1.4826;  // (p50 - p25) of a normal distribution to its sigma
constexpr double kNear = 0.1;
constexpr double kBehind = 0.02;  // relative: how far behind a thing the fit must see something

VoxelGrid<float> grid_of(const ViewSet& set, int cells) {
  Vec3d low{-kFarthest, -kFarthest, -kFarthest}, high{kFarthest, kFarthest, kFarthest};
  for (size_t axis = 0; axis < 3 && !set.points.empty(); ++axis) {
    std::vector<double> along;
    for (const ScenePoint& p : set.points) along.push_back(p.position[axis]);
    const double a = quantile_of(along, kLowShare), b = quantile_of(along, kHighShare);
    low[axis] = std::clamp(a - kBoxMargin * (b - a), -kFarthest, kFarthest);
    high[axis] = std::clamp(b + kBoxMargin * (b - a), low[axis], kFarthest);
  }
  VoxelGrid<float> grid{low, std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-3}) / cells, {}, {}};
  for (size_t axis = 0; axis < 3; ++axis) grid.size[axis] = int((high[axis] - low[axis]) / grid.cell) + 1;
  grid.values.assign(grid.count(), NAN);
  return grid;
}

void score_cells(const HullVoteConfig& config, const std::vector<SmallPhoto>& photos, const QuickFit& fit,
                 const std::vector<DeviationMap>& deviations, VoxelGrid<float>& grid) {
  parallel_chunks(grid.count(), 4096, [&](size_t, size_t begin, size_t end) {
    std::vector<float> votes;
    for (size_t i = begin; i < end; ++i) {
      const auto [x, y, z] = grid.cell_at(i);
      const Vec3d centre = grid.centre(x, y, z);
      votes.clear();
      size_t seen = 0;
      for (size_t v = 0; v < photos.size(); ++v) {
        const View& view = photos[v].view;
        const auto p = image_point(centre, view, kNear);
        if (!p) continue;
        const size_t pixel = size_t(p->y) * size_t(view.intrinsics.width) + size_t(p->x);
        const double seen_z = fit.views[v].zdepth[pixel];
        if (seen_z > 0 && seen_z < kHidden * p->z) continue;
        ++seen;
        if (const float d = deviations[v].value[pixel]; std::isfinite(d)) votes.push_back(d);
      }
      if (double(seen) < config.min_views * double(photos.size()) || double(votes.size()) < kVotes * double(seen) ||
          votes.size() < kFewestVotes)
        continue;
      grid.values[i] = quantile_of(votes, kQuantile);
    }
  });
}

// Groups of voxels above the weak threshold, by faces, that hold enough voxels above the strong one.
void group(HullVote& vote) {
  const VoxelGrid<float>& g = vote.score;
  vote.thing.assign(g.count(), -1);
  for (const auto& members : connected_components(g, [&](size_t i) { return g.values[i] > vote.weak; }).members) {
    size_t strong = 0;
    double sum = 0;
    for (size_t i : members) strong += g.values[i] > vote.strong, sum += g.values[i];
    if (members.size() < kSmallestThing || double(strong) < kStrongShare * double(members.size())) continue;
    ProposedThing thing{.voxels = members.size(), .score = sum / double(members.size())};
    for (size_t i : members) {
      vote.thing[i] = int(vote.things.size());
      const auto [x, y, z] = g.cell_at(i);
      thing.centre += g.centre(x, y, z) / double(members.size());
    }
    vote.things.push_back(thing);
  }
}

// A voxel between voxels of one thing along two of the three axes belongs to it: what stands inside hides its own middle.
void fill(HullVote& vote) {
  const VoxelGrid<float>& g = vote.score;
  for (size_t t = 0; t < vote.things.size(); ++t) {
    std::vector<uint8_t> between(g.count(), 0);
    const auto line = [&](auto&& at, int length) {
      int first = -1, last = -1;
      for (int i = 0; i < length; ++i)
        if (vote.thing[at(i)] == int(t)) {
          if (first < 0) first = i;
          last = i;
        }
      for (int i = first; first >= 0 && i <= last; ++i) ++between[at(i)];
    };
    for (int z = 0; z < g.size[2]; ++z)
      for (int y = 0; y < g.size[1]; ++y) line([&](int i) { return g.index(i, y, z); }, g.size[0]);
    for (int z = 0; z < g.size[2]; ++z)
      for (int x = 0; x < g.size[0]; ++x) line([&](int i) { return g.index(x, i, z); }, g.size[1]);
    for (int y = 0; y < g.size[1]; ++y)
      for (int x = 0; x < g.size[0]; ++x) line([&](int i) { return g.index(x, y, i); }, g.size[2]);
    for (size_t i = 0; i < g.count(); ++i)
      if (vote.thing[i] < 0 && between[i] >= 2) vote.thing[i] = int(t);
  }
}

struct Crossing {
  int thing = -1;
  double enter_z = 0, leave_z = 0;
};

// First thing along a ray, with where the ray enters and last leaves it. Stops at `limit`.
Crossing first_crossing(const HullVote& vote, const Vec3d& origin, const Vec3d& direction, double limit) {
  const VoxelGrid<float>& g = vote.score;
  double enter = kNear, leave = limit;
  const Vec3d high = g.high();
  for (size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(direction[axis]) < 1e-12) {
      if (origin[axis] < g.origin[axis] || origin[axis] >= high[axis]) return {};
      continue;
    }
    double a = (g.origin[axis] - origin[axis]) / direction[axis], b = (high[axis] - origin[axis]) / direction[axis];
    if (a > b) std::swap(a, b);
    enter = std::max(enter, a);
    leave = std::min(leave, b);
  }
  Crossing crossing;
  const double step = 0.7 * g.cell / length(direction);
  for (double t = enter; t < leave; t += step) {
    const auto [x, y, z] = g.cell_of(origin + t * direction);
    if (!g.has(x, y, z)) continue;
    const int found = vote.thing[g.index(x, y, z)];
    if (crossing.thing < 0 && found >= 0) crossing = {found, t, t};
    if (found >= 0 && found == crossing.thing) crossing.leave_z = t;
  }
  return crossing;
}

template <class F>
void for_each_crossing(const HullVote& vote, const SmallPhoto& photo, const FittedView& fitted, double beyond, F&& visit) {
  const Intrinsics& k = photo.view.intrinsics;
  const Rigid world_from_cam = inverse(photo.view.cam_from_world);
  constexpr double kFar = 1e3;
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const size_t pixel = size_t(y) * size_t(k.width) + size_t(x);
      const double z = fitted.zdepth[pixel];
      visit(pixel, first_crossing(vote, world_from_cam.translation, world_from_cam.rotation * k.ray(x + 0.5, y + 0.5),
                                  z > 0 ? beyond * z : kFar));
    }
}

// Glass lets the fit see what stands behind it; metal does not.
void tell_glass_from_metal(HullVote& vote, const std::vector<SmallPhoto>& photos, const QuickFit& fit) {
  constexpr double kAll = 1e3;
  std::vector<std::vector<std::array<size_t, 2>>> counts(photos.size());
  parallel_for(photos.size(), 1, [&](size_t v) {
    counts[v].assign(vote.things.size(), {0, 0});
    for_each_crossing(vote, photos[v], fit.views[v], kAll, [&](size_t pixel, const Crossing& c) {
      const double z = fit.views[v].zdepth[pixel];
      if (c.thing < 0 || (z > 0 && z < c.enter_z)) return;
      ++counts[v][size_t(c.thing)][0];
      counts[v][size_t(c.thing)][1] += !(z > 0) || z > (1 + kBehind) * c.leave_z;
    });
  });
  for (size_t t = 0; t < vote.things.size(); ++t) {
    double all = 0, through = 0, share = 0;
    for (size_t v = 0; v < photos.size(); ++v) {
      all += double(counts[v][t][0]);
      through += double(counts[v][t][1]);
      share += double(counts[v][t][0]) / double(fit.views[v].zdepth.size()) / double(photos.size());
    }
    ProposedThing& thing = vote.things[t];
    thing.see_through = all > 0 ? through / all : 0;
    thing.coverage = share;
    thing.transparent = thing.see_through > kSeeThrough;
  }
}

}  // namespace

void describe(Describer& d, HullVoteConfig& c) {
  d.option("grid", c.grid, "Voxels along the longest side of the scene's box.").range(8, 512);
  d.option("min_views", c.min_views, "Share of the photos that must see a voxel: what was not walked around is not judged.")
      .range(0.1, 1);
  d.option("weak_sigma", c.weak_sigma, "How far a voxel must stand out of the others to belong to a thing.").range(0, 100);
  d.option("strong_sigma", c.strong_sigma, "How far some voxels of a thing must stand out.").range(0, 100);
  d.option("min_deviation", c.min_deviation, "What views must at least differ by, in sRGB units from 0 to 1.").range(0, 1);
  d.option("max_typical", c.max_typical, "Typical difference above which the fit is too coarse to propose anything.").range(0, 1);
}

HullVote hull_vote(const HullVoteConfig& config, const MaskCapture& capture, const std::vector<SmallPhoto>& photos,
                   const QuickFit& fit, const std::vector<DeviationMap>& deviations) {
  HullVote vote;
  vote.score = grid_of(capture.set, config.grid);
  score_cells(config, photos, fit, deviations, vote.score);
  vote.thing.assign(vote.score.count(), -1);
  std::vector<float> known;
  for (float s : vote.score.values)
    if (std::isfinite(s)) known.push_back(s);
  vote.unsure = known.size() < kFewestVoxels;
  if (vote.unsure) return vote;
  vote.typical = upper_median_of(std::span(known));
  // From the lower half: the upper one may be full of glass.
  const double sigma = kNormalQuartile * (vote.typical - order_statistic_of(std::span(known), known.size() / 4));
  vote.weak = std::max(vote.typical + config.weak_sigma * sigma, config.min_deviation);
  vote.strong = std::max(vote.typical + config.strong_sigma * sigma, kStrongRatio * config.min_deviation);
  vote.unsure = vote.typical > config.max_typical;
  if (vote.unsure) return vote;
  group(vote);
  fill(vote);
  tell_glass_from_metal(vote, photos, fit);
  return vote;
}

std::vector<int> projected_things(const HullVote& vote, const SmallPhoto& photo, const FittedView& fitted) {
  constexpr double kTolerance = 1.03;
  std::vector<int> things(fitted.zdepth.size(), -1);
  for_each_crossing(vote, photo, fitted, kTolerance, [&](size_t pixel, const Crossing& c) { things[pixel] = c.thing; });
  return things;
}

}  // namespace vitrine
