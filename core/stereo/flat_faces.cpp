#include "core/stereo/flat_faces.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "core/base/parallel.h"

namespace vitrine {

namespace {

constexpr size_t kMostPoints = 8000, kMostCandidates = 1000;
constexpr double kWithin = 2.5;          // voxels between the surface and a face
constexpr double kTurnedWithin = 0.8;    // cosine between the normals of a face and of its points: a bulge
constexpr double kNearestTurn = 0.7071;  // the same, of a point that is put on a face
constexpr size_t kMostFaces = 12;
constexpr double kLeastEven = 0.65;
constexpr double kLeastFace = 0.07, kLeastFlat = 2.0 / 3;  // shares of the surface

bool lies_on(const ShapePoint& p, const FlatFace& face, double tolerance) {
  return std::abs(dot(face.normal, p.position) - face.offset) < tolerance && dot(face.normal, p.normal) > kTurnedWithin;
}

size_t support(const std::vector<ShapePoint>& points, const FlatFace& face, double tolerance) {
  return size_t(std::count_if(points.begin(), points.end(), [&](const ShapePoint& p) { return lies_on(p, face, tolerance); }));
}

// Least squares over the points on the face.
FlatFace refitted(const std::vector<ShapePoint>& points, const FlatFace& face, double tolerance) {
  Vec3d mean{}, outwards{};
  double count = 0;
  for (const ShapePoint& p : points)
    if (lies_on(p, face, tolerance)) mean += p.position, outwards += p.normal, count += 1;
  if (count < 3) return face;
  mean = mean / count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const ShapePoint& p : points)
    if (lies_on(p, face, tolerance)) {
      const Vec3d d = p.position - mean;
      const Eigen::Vector3d e(d.x, d.y, d.z);
      scatter += e * e.transpose();
    }
  const Eigen::Vector3d n = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  Vec3d normal{n.x(), n.y(), n.z()};
  if (dot(normal, outwards) < 0) normal = -1.0 * normal;
  return {normal, dot(normal, mean), {}};
}

// Share of a face's points that lie on it within half the tolerance. A piece of a ball or a cylinder is as often at any distance
// from the plane through it: 0.5; of a flat face only the rims leave it.
double evenness(const std::vector<ShapePoint>& points, const FlatFace& face, double tolerance) {
  return double(support(points, face, 0.5 * tolerance)) / double(std::max(support(points, face, tolerance), size_t(1)));
}

}  // namespace

std::vector<FlatFace> flat_faces(std::span<const ShapePoint> surface, double voxel) {
  const double tolerance = kWithin * voxel;
  std::vector<ShapePoint> points;
  const size_t step = surface.size() / kMostPoints + 1;
  for (size_t i = 0; i < surface.size(); i += step) points.push_back(surface[i]);
  const double all = double(points.size());
  std::vector<FlatFace> faces;
  double flat = 0;
  for (size_t round = 0; round < kMostFaces && !points.empty(); ++round) {
    const size_t apart = points.size() / kMostCandidates + 1;
    std::vector<std::pair<size_t, FlatFace>> candidates;
    for (size_t i = 0; i < points.size(); i += apart)
      candidates.push_back({0, {points[i].normal, dot(points[i].normal, points[i].position), {}}});
    parallel_for(candidates.size(), 32,
                 [&](size_t c) { candidates[c].first = support(points, candidates[c].second, tolerance); });
    FlatFace best = std::max_element(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
                      return a.first < b.first;
                    })->second;
    for (int again = 0; again < 5; ++again) best = refitted(points, best, tolerance);
    const double share = double(support(points, best, tolerance)) / all;
    if (share < kLeastFace) break;
    if (evenness(points, best, tolerance) > kLeastEven) {
      for (const ShapePoint& p : points)
        if (lies_on(p, best, tolerance)) best.bounds.extend(p.position);
      faces.push_back(best);
      flat += share;
    }
    std::erase_if(points, [&](const ShapePoint& p) { return lies_on(p, best, tolerance); });
  }
  if (flat < kLeastFlat) faces.clear();
  return faces;
}

const FlatFace* face_of(std::span<const FlatFace> faces, const ShapePoint& point, double voxel) {
  const double reach = 2 * kWithin * voxel;
  const FlatFace* nearest = nullptr;
  double turned = kNearestTurn;
  for (const FlatFace& face : faces) {
    if (std::abs(dot(face.normal, point.position) - face.offset) > reach) continue;
    bool beside = false;
    for (size_t i = 0; i < 3; ++i)
      beside |= point.position[i] < face.bounds.low[i] - reach || point.position[i] > face.bounds.high[i] + reach;
    if (beside) continue;
    if (const double cosine = dot(face.normal, point.normal); cosine > turned) turned = cosine, nearest = &face;
  }
  return nearest;
}

}  // namespace vitrine
