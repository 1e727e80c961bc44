
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/median.h"
#include "core/observe/stereo/box_fit.h"
#include "core/observe/stereo/upright_edges.h"

namespace vitrine {

namespace {

constexpr int kCoarseSide = 320, kFineSide = 640;  // pixels: photo size for the plan search; for the box fit
constexpr size_t kMostEdges = 240, kMostPlans = 24, kFewestBoxPhotos = 8;
constexpr double kLeastSide = 0.06, kMostAspect = 5;  // in radii of the camera ring
constexpr double kSameMiddle = 2, kSameLength = 3;    // cells: tolerances for the diagonals of a rectangle
constexpr double kWeakest = 0.45;  // of the mean strength of four vertical edges: rejects three edges and a chance one
constexpr size_t kRimSteps = 320, kEdgeSamples = 24;
constexpr double kRimBelow = 0.4,
                 kRimAbove = 0.5;  // of the height of the vertical edges: search range of the rim around their upper ends
constexpr double kEndsOut = 0.04;  // of an edge's length, excluded at both ends: corners belong to other edges too
constexpr double kBoxFirstMove = 0.01, kBoxLastMove = 2e-4;  // of the diagonal; radians

// Mean edge strength along a segment from a to b, over photos and samples; 0 where no photo sees it.
double edge_between(std::span<const EdgeField> fields, const Vec3d& a, const Vec3d& b) {
  double sum = 0;
  size_t seen = 0;
  const Vec3d along = b - a;
  for (size_t i = 0; i < kEdgeSamples; ++i) {
    const double t = kEndsOut + (1 - 2 * kEndsOut) * (double(i) + 0.5) / double(kEdgeSamples);
    for (const EdgeField& field : fields)
      if (const float edge = field.along(a + t * along, along); edge >= 0) sum += double(edge), ++seen;
  }
  return seen > 0 ? sum / double(seen) : 0;
}

// Mean edge strength around the box at a height along its third axis.
double edge_around(std::span<const EdgeField> fields, const Box& box, double z) {
  const std::array<Vec3d, 4> corners{box.axes * Vec3d{box.low.x, box.low.y, z}, box.axes * Vec3d{box.high.x, box.low.y, z},
                                     box.axes * Vec3d{box.high.x, box.high.y, z}, box.axes * Vec3d{box.low.x, box.high.y, z}};
  double sum = 0;
  for (size_t i = 0; i < 4; ++i) sum += edge_between(fields, corners[i], corners[(i + 1) % 4]);
  return sum / 4;
}

struct Rectangle {
  std::array<UprightEdge, 4> corners;  // in order
  UprightEdges::Run run;
};

// Finds rectangles: two pairs of points with the same midpoint and the same length are the diagonals of one.
std::vector<Rectangle> rectangles(const UprightEdges& upright, double least_posts) {
  const std::vector<UprightEdge> edges = upright.strongest(kMostEdges);
  const double cell = upright.cell();
  struct Pair {
    size_t a, b;
    double x, y, length;
  };
  std::vector<Pair> pairs;
  for (size_t a = 0; a < edges.size(); ++a)
    for (size_t b = a + 1; b < edges.size(); ++b)
      pairs.push_back({a, b, 0.5 * (edges[a].x + edges[b].x), 0.5 * (edges[a].y + edges[b].y),
                       std::hypot(edges[a].x - edges[b].x, edges[a].y - edges[b].y)});
  std::ranges::sort(pairs, {}, [](const Pair& p) { return std::tuple(p.length, p.a, p.b); });
  std::vector<Rectangle> found;
  for (size_t i = 0; i < pairs.size(); ++i)
    for (size_t j = i + 1; j < pairs.size() && pairs[j].length - pairs[i].length < kSameLength * cell; ++j) {
      const Pair &p = pairs[i], &q = pairs[j];
      if (std::hypot(p.x - q.x, p.y - q.y) > kSameMiddle * cell || p.a == q.a || p.a == q.b || p.b == q.a || p.b == q.b) continue;
      Rectangle r{{edges[p.a], edges[q.a], edges[p.b], edges[q.b]}, {}};
      const auto side = [&](size_t k) {
        return std::hypot(r.corners[k].x - r.corners[k + 1].x, r.corners[k].y - r.corners[k + 1].y);
      };
      const double s = side(0), t = side(1);
      if (std::min(s, t) < kLeastSide || std::max(s, t) > kMostAspect * std::min(s, t)) continue;
      r.run = upright.together(r.corners);
      if (r.run.total >= least_posts && r.run.weakest >= kWeakest * r.run.total) found.push_back(r);
    }
  std::ranges::stable_sort(found, std::greater<>(), [](const Rectangle& r) { return r.run.total; });
  if (found.size() > kMostPlans) found.resize(kMostPlans);
  return found;
}

// Box with the mean width of the four corners.
Box box_on(const Rectangle& r) {
  const auto at = [&](size_t i) { return Vec3d{r.corners[i].x, r.corners[i].y, 0}; };
  const Vec3d middle = 0.25 * (at(0) + at(1) + at(2) + at(3)), s = 0.5 * (at(1) - at(0) + at(2) - at(3)),
              t = 0.5 * (at(3) - at(0) + at(2) - at(1));
  Box box;
  box.axes = turned(2, std::atan2(s.y, s.x));
  const Vec3d centre = transposed_times(box.axes, middle);
  const Vec3d half{0.5 * length(s), 0.5 * length(t), 0};
  box.low = centre - half, box.high = centre + half;
  box.low.z = r.run.low, box.high.z = r.run.high;
  return box;
}

// Height of the rim, and its strength relative to other heights.
std::pair<double, double> rim_of(std::span<const EdgeField> fields, const Box& box, const Bounds3& about) {
  const double height = box.high.z - box.low.z, first = about.low.z,
               last = std::max(about.high.z, box.high.z) + kRimAbove * height;
  std::vector<double> edges(kRimSteps);
  const auto z = [&](size_t i) { return first + (last - first) * double(i) / double(kRimSteps - 1); };
  parallel_for(kRimSteps, 4, [&](size_t i) { edges[i] = edge_around(fields, box, z(i)); });
  const double middle = upper_median(edges);
  std::vector<double> off;
  for (double e : edges) off.push_back(std::abs(e - middle));
  const double sigma = kSigmaPerDeviation * upper_median(off);
  size_t best = kRimSteps;
  for (size_t i = 0; i < kRimSteps; ++i)
    if (z(i) >= box.high.z - kRimBelow * height && z(i) <= box.high.z + kRimAbove * height &&
        (best == kRimSteps || edges[i] > edges[best]))
      best = i;
  if (best == kRimSteps || !(sigma > 0)) return {box.high.z, 0};
  return {z(best), (edges[best] - middle) / sigma};
}

// Maximises the edge strength along the vertical edges and, if `rim`, the rim. Keeps the height of the foot.
void draw_to_edges(std::span<const EdgeField> fields, bool rim, Box& box) {
  static constexpr std::array<size_t, 8> kNumbers{0, 1, 2, 3, 6, 7, 8, 5};
  improve(
      [&](const Box& trial) {
        std::array<double, 5> edges{};
        parallel_for(rim ? 5 : 4, 1, [&](size_t i) {
          edges[i] =
              i < 4 ? edge_between(fields, trial.corner(i), trial.corner(i + 4)) : 4 * edge_around(fields, trial, trial.high.z);
        });
        return edges[0] + edges[1] + edges[2] + edges[3] + edges[4];
      },
      kBoxFirstMove, kBoxLastMove, box, std::span(kNumbers).first(rim ? 8 : 7));
}

}  // namespace

std::vector<StandingBox> standing_boxes(std::span<const EdgePhoto> photos, const Bounds3& about, double least_posts) {
  if (photos.size() < kFewestBoxPhotos || about.empty()) return {};
  const std::vector<EdgeField> coarse = edge_fields(photos, kCoarseSide);
  const std::vector<Rectangle> plans = rectangles(UprightEdges(coarse, about), least_posts);
  if (plans.empty()) return {};
  const std::vector<EdgeField> fine = edge_fields(photos, kFineSide);
  std::vector<StandingBox> found;
  for (const Rectangle& r : plans) {
    StandingBox standing{box_on(r), r.run.total, 0};
    draw_to_edges(fine, false, standing.box);
    std::tie(standing.box.high.z, standing.rim) = rim_of(fine, standing.box, about);
    if (!(standing.box.high.z > standing.box.low.z)) continue;
    draw_to_edges(fine, true, standing.box);
    found.push_back(standing);
  }
  std::ranges::stable_sort(found, std::greater<>(), [](const StandingBox& b) { return b.posts * b.rim; });
  return found;
}

Box drawn_to_edges(const Box& start, std::span<const EdgePhoto> photos) {
  Box box = start;
  draw_to_edges(edge_fields(photos, kFineSide), true, box);
  return box;
}

}  // namespace vitrine
