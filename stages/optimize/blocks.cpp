#include "stages/optimize/blocks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

double along(const Vec2d& direction, const Vec3d& p) { return direction.x * p.x + direction.y * p.y; }

// Horizontal direction of the largest variance.
Vec2d longest_direction(std::span<const Vec3d> centres, std::span<const uint32_t> cameras) {
  Vec2d mean{};
  for (uint32_t c : cameras) mean.x += centres[c].x / double(cameras.size()), mean.y += centres[c].y / double(cameras.size());
  double xx = 0, xy = 0, yy = 0;
  for (uint32_t c : cameras) {
    const double x = centres[c].x - mean.x, y = centres[c].y - mean.y;
    xx += x * x, xy += x * y, yy += y * y;
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  return {std::cos(angle), std::sin(angle)};
}

[[noreturn]] void throw_one_place(int blocks) {
  throw Error(ErrorKind::Usage, fmt::format("the cameras do not stand in {} places", blocks),
              {.why = "blocks are cut between cameras, and those of one block stand in one point",
               .hint = blocks > 2 ? fmt::format("--blocks {}", blocks / 2) : "leave out --blocks",
               .code = "BLOCKS_NO_PLACE"});
}

// The place nearest to `wanted` in sorted values where neighbours differ.
size_t place_of_cut(const std::vector<double>& values, size_t wanted, int blocks) {
  size_t best = 0;
  const auto distance = [&](size_t i) { return i > wanted ? i - wanted : wanted - i; };
  for (size_t i = 1; i < values.size(); ++i)
    if (values[i] > values[i - 1] && (best == 0 || distance(i) < distance(best))) best = i;
  if (best == 0) throw_one_place(blocks);
  return best;
}

}  // namespace

BlockCells::BlockCells(std::span<const Vec3d> centres, int blocks) {
  std::vector<uint32_t> cameras(centres.size());
  std::iota(cameras.begin(), cameras.end(), 0u);
  root_ = split(centres, std::move(cameras), blocks);
}

int BlockCells::split(std::span<const Vec3d> centres, std::vector<uint32_t> cameras, int blocks) {
  if (blocks <= 1) return ~int(count_++);
  if (cameras.size() < 2) throw_one_place(blocks);
  const Vec2d direction = longest_direction(centres, cameras);
  const auto value = [&](uint32_t c) { return along(direction, centres[c]); };
  std::ranges::sort(cameras, [&](uint32_t a, uint32_t b) { return value(a) != value(b) ? value(a) < value(b) : a < b; });
  std::vector<double> values;
  for (uint32_t c : cameras) values.push_back(value(c));
  const int first = blocks / 2;
  const size_t place = place_of_cut(values, cameras.size() * size_t(first) / size_t(blocks), blocks);
  const auto middle = cameras.begin() + std::ptrdiff_t(place);
  const size_t cut = cuts_.size();
  cuts_.push_back({direction, 0.5 * (values[place - 1] + values[place])});
  const int below = split(centres, {cameras.begin(), middle}, first);
  const int above = split(centres, {middle, cameras.end()}, blocks - first);
  cuts_[cut].first = below, cuts_[cut].second = above;
  return int(cut);
}

size_t BlockCells::cell_of(const Vec3d& position) const {
  int at = root_;
  while (at >= 0) {
    const Cut& cut = cuts_[size_t(at)];
    at = along(cut.direction, position) < cut.offset ? cut.first : cut.second;
  }
  return size_t(~at);
}

BlockPlan planned_blocks(const ViewSet& views, std::span<const uint32_t> train, int blocks) {
  // A photo trains a block if at least this share of its sparse points lies in the cell, or its camera stands there. Small,
  // because the sky behind a cell, which has no points, may be seen from other cells alone.
  constexpr double kSeenShare = 0.02;
  constexpr size_t kFewestPhotos = 10;
  if (views.points.empty())
    throw Error(ErrorKind::Input, "no sparse point shows which photos see which block",
                {.why = "the sfm stage found none, or poses without points were given",
                 .hint = "leave out --blocks, or photos with more overlap and texture",
                 .code = "NO_SPARSE_POINTS"});
  std::vector<Vec3d> centres;
  for (uint32_t v : train) centres.push_back(views.views[v].centre_in_world());
  BlockPlan plan{BlockCells(centres, blocks), std::vector<Block>(size_t(blocks))};
  std::vector<std::vector<size_t>> seen(views.views.size(), std::vector<size_t>(size_t(blocks), 0));  // [view][block] points
  for (const ScenePoint& point : views.points) {
    const size_t cell = plan.cells.cell_of(point.position);
    for (uint32_t v : point.views) ++seen[v][cell];
  }
  for (size_t b = 0; b < plan.blocks.size(); ++b) {
    Block& block = plan.blocks[b];
    block.photos.assign(views.views.size(), 0);
    for (size_t t = 0; t < train.size(); ++t) {
      const std::vector<size_t>& of = seen[train[t]];
      const double all = double(std::accumulate(of.begin(), of.end(), size_t(0)));
      const bool sees = of[b] > 0 && double(of[b]) >= kSeenShare * all;
      if (!sees && plan.cells.cell_of(centres[t]) != b) continue;
      block.photos[train[t]] = 1;
      ++block.photo_count;
    }
    const auto points = std::ranges::count_if(views.points, [&](const ScenePoint& p) {
      return std::ranges::any_of(p.views, [&](uint32_t v) { return block.photos[v] != 0; });
    });
    block.photo_share = double(block.photo_count) / double(train.size());
    block.point_share = double(points) / double(views.points.size());
    if (block.photo_count >= kFewestPhotos) continue;
    throw Error(ErrorKind::Usage, fmt::format("{} blocks are too many for {} photos", blocks, train.size()),
                {.why = fmt::format("block {} would have {} photos to train on, at least {} are needed", b + 1, block.photo_count,
                                    kFewestPhotos),
                 .hint = blocks > 2 ? fmt::format("--blocks {}", blocks / 2) : "leave out --blocks",
                 .code = "BLOCKS_TOO_MANY"});
  }
  return plan;
}

OptimizeConfig config_of_block(const OptimizeConfig& whole, const Block& block) {
  const auto part = [](int value, double share) { return std::max(1, int(std::lround(double(value) * share))); };
  OptimizeConfig config = whole;
  config.blocks = 1;
  config.iterations = part(whole.iterations, block.photo_share);
  config.max_gaussians = part(whole.max_gaussians, block.point_share);
  if (whole.initial.frustum_points > 0) config.initial.frustum_points = part(whole.initial.frustum_points, block.point_share);
  return config;
}

std::string blocks_problem(const OptimizeConfig& config) {
  if (config.blocks <= 1) return {};
  const char* other = config.layers == WantedLayers::Reflection || config.layers == WantedLayers::Full ? "layers"
                      : config.medium != WantedMedium::Off                                             ? "medium"
                      : config.transients != WantedTransients::Off                                     ? "transients"
                      : config.poses != WantedPoses::Given                                             ? "poses"
                      : config.surroundings == WantedSurroundings::Ignore                              ? "surroundings"
                                                                                                       : nullptr;
  if (other == nullptr) return {};
  return fmt::format("blocks = {} trains one opaque layer of a scene that stands still, in air: leave '{}' at its default",
                     config.blocks, other);
}

}  // namespace vitrine
