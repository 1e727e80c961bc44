#include "core/observe/stereo/shape_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/projection.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/mesh/mesh_hits.h"

namespace vitrine {

namespace {

constexpr float kMaskEdge = 0.5f;       // coverage
constexpr double kSampleStep = 0.5;     // pixels, step of the mask-edge search
constexpr double kOutwardOffset = 1.5;  // pixels outside a contour vertex: no contour if the mesh covers that point too
constexpr double kLeastReach = 2.5;     // pixels
constexpr double kRobust = 0.25;        // of the mean edge length: residual with weight one half
constexpr int kReweighted = 3;          // reweighted solves per round
constexpr double kRelaxed = 0.5;     // tangential smoothing: share of the way to the mean of the neighbours
constexpr double kRest = 1e-3;       // damping weight for vertices without observations
constexpr double kMostStep = 1.0;    // maximum step per round, in mean edge lengths

using Sparse = Eigen::SparseMatrix<double>;

// A contour vertex in one photo, and the signed distance to the mask edge along its normal.
struct Contact {
  uint32_t vertex;
  double away;  // scene units
};

double mean_edge(const TriMesh& mesh, const VertexNeighbours& near) {
  double sum = 0;
  for (size_t v = 0; v < mesh.positions.size(); ++v)
    for (const uint32_t n : near.of(v)) sum += double(length(mesh.positions[n] - mesh.positions[v]));
  return near.vertex.empty() ? 0 : sum / double(near.vertex.size());
}

// Signed distance in pixels along `out` to the nearest mask edge, at most `reach`; nullopt where the mask is unknown.
std::optional<double> edge_along(const ImageF& mask, Vec2d at, Vec2d out, double reach) {
  const auto value = [&](double s) { return coverage_at(mask, at.x + s * out.x, at.y + s * out.y); };
  const float here = value(0);
  if (here < 0) return std::nullopt;
  const double sign = here >= kMaskEdge ? 1 : -1;
  float before = here;
  for (double s = kSampleStep; s <= reach; s += kSampleStep) {
    const float now = value(sign * s);
    if (now < 0) return std::nullopt;
    if ((now >= kMaskEdge) != (here >= kMaskEdge)) {
      const double part = double(before - kMaskEdge) / double(before - now);
      return sign * (s - kSampleStep + part * kSampleStep);
    }
    before = now;
  }
  return std::nullopt;
}

// Contour vertices: between front-facing and back-facing faces, where the photo does not see the mesh just outside them.
std::vector<Contact> contacts(const TriMesh& mesh, const MeshHits& hits, const Silhouette& s, double reach) {
  const Vec3d eye = s.view.centre_in_world();
  std::vector<uint8_t> sides(mesh.positions.size(), 0);  // bit 0: has a front-facing face; bit 1: has a back-facing one
  for (const auto& f : mesh.faces) {
    const Vec3d a = cast<double>(mesh.positions[f[0]]), b = cast<double>(mesh.positions[f[1]]),
                c = cast<double>(mesh.positions[f[2]]);
    const uint8_t side = dot(cross(b - a, c - a), eye - a) > 0 ? 1 : 2;
    for (const uint32_t v : f) sides[v] |= side;
  }
  std::vector<Contact> out;
  for (uint32_t v = 0; v < sides.size(); ++v) {
    if (sides[v] != 3) continue;
    const Vec3d p = cast<double>(mesh.positions[v]), n = cast<double>(mesh.normals[v]);
    const auto at = projection(p, s.view, 1e-6);
    if (!at) continue;
    const double pixel = at->z / s.view.intrinsics.fx;  // pixel size in scene units
    const auto offset = projection(p + pixel * n, s.view, 1e-6);
    if (!offset) continue;
    Vec2d outwards{offset->x - at->x, offset->y - at->y};
    const double pixels = std::hypot(outwards.x, outwards.y);
    if (!(pixels > 0.5)) continue;
    outwards = (1 / pixels) * outwards;
    const Vec3d way = s.view.ray(at->x + kOutwardOffset * outwards.x, at->y + kOutwardOffset * outwards.y);
    if (hits.first_face(cast<float>(eye), cast<float>(way))) continue;
    const auto edge = edge_along(s.value, {at->x, at->y}, outwards, std::max(kLeastReach, reach / pixel));
    if (edge) out.push_back({v, *edge / pixels * pixel});
  }
  return out;
}

// Minimises over the steps along the normals:
// sum over contours of |step - away| (reweighted squares) + stiffness |L (x + step n)|^2 / edge.
class Plate {
 public:
  explicit Plate(const TriMesh& mesh) : near_(mesh) {
    const auto n = static_cast<Eigen::Index>(mesh.positions.size());
    std::vector<Eigen::Triplet<double>> entries;
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
      const auto around = near_.of(v);
      if (around.empty()) continue;
      entries.emplace_back(v, v, 1.0);
      for (const uint32_t o : around) entries.emplace_back(v, o, -1.0 / double(around.size()));
    }
    Sparse laplacian(n, n);
    laplacian.setFromTriplets(entries.begin(), entries.end());
    bending_ = laplacian.transpose() * laplacian;
  }
  const VertexNeighbours& neighbours() const { return near_; }

  std::vector<double> steps(const TriMesh& mesh, const std::vector<Contact>& contacts, double stiffness, double edge) {
    const auto n = static_cast<Eigen::Index>(mesh.positions.size());
    Eigen::MatrixXd x(n, 3), normal(n, 3);
    for (Eigen::Index v = 0; v < n; ++v)
      for (int c = 0; c < 3; ++c) {
        x(v, c) = double(mesh.positions[size_t(v)][size_t(c)]);
        normal(v, c) = double(mesh.normals[size_t(v)][size_t(c)]);
      }
    const Eigen::MatrixXd bent = bending_ * x;
    const Eigen::VectorXd pull = stiffness * (bent.cwiseProduct(normal)).rowwise().sum();
    Sparse along = bending_;
    for (int k = 0; k < along.outerSize(); ++k)
      for (Sparse::InnerIterator it(along, k); it; ++it)
        it.valueRef() *= stiffness * normal.row(it.row()).dot(normal.row(it.col()));
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
    for (int pass = 0; pass < kReweighted; ++pass) {
      Eigen::VectorXd weight = Eigen::VectorXd::Constant(n, kRest), right = -pull;
      for (const Contact& c : contacts) {
        const double w = 1 / (1 + std::abs(c.away - step[c.vertex]) / (kRobust * edge));
        weight[c.vertex] += w;
        right[c.vertex] += w * c.away;
      }
      Sparse system = along;
      for (Eigen::Index v = 0; v < n; ++v) system.coeffRef(v, v) += weight[v];
      if (!analysed_) solver_.analyzePattern(system), analysed_ = true;
      solver_.factorize(system);
      if (solver_.info() != Eigen::Success) break;
      step = solver_.solve(right);
    }
    return {step.data(), step.data() + n};
  }

 private:
  VertexNeighbours near_;
  Sparse bending_;
  Eigen::SimplicialLDLT<Sparse> solver_;
  bool analysed_ = false;
};

// Tangential smoothing towards the mean of the neighbours.
void relax(const VertexNeighbours& near, TriMesh& mesh) {
  const std::vector<Vec3f> before = mesh.positions;
  for (size_t v = 0; v < before.size(); ++v) {
    const auto around = near.of(v);
    if (around.empty()) continue;
    Vec3f middle{};
    for (const uint32_t o : around) middle += before[o] / float(around.size());
    Vec3f way = middle - before[v];
    way -= dot(way, mesh.normals[v]) * mesh.normals[v];
    mesh.positions[v] += float(kRelaxed) * way;
  }
}

}  // namespace

MeshFit fit_mesh(std::span<const Silhouette> masks, TriMesh start, const MeshFitDesc& desc) {
  MeshFit out{std::move(start), 0, 0};
  TriMesh& mesh = out.mesh;
  if (mesh.faces.empty()) return out;
  Plate plate(mesh);
  Bounds3 bounds;
  for (const Vec3f& p : mesh.positions) bounds.extend(cast<double>(p));
  const double size = bounds.diagonal();
  std::vector<Contact> all;
  for (int round = 0; round <= desc.rounds; ++round) {
    throw_if_interrupted();
    const double done = std::min(1.0, double(round) / std::max(1.0, 0.75 * desc.rounds));
    const double reach = size * desc.reach * std::pow(desc.last_reach / desc.reach, done);
    const double stiffness = desc.first_stiffness * std::pow(desc.stiffness / desc.first_stiffness, done);
    mesh.normals = vertex_normals(mesh);
    const MeshHits hits(mesh);
    std::vector<std::vector<Contact>> each(masks.size());
    parallel_for(masks.size(), 1, [&](size_t i) { each[i] = contacts(mesh, hits, masks[i], reach); });
    all.clear();
    for (const auto& of_photo : each) all.insert(all.end(), of_photo.begin(), of_photo.end());
    if (round == desc.rounds || all.empty()) break;
    const double edge = mean_edge(mesh, plate.neighbours());
    const std::vector<double> steps = plate.steps(mesh, all, stiffness, edge);
    for (size_t v = 0; v < mesh.positions.size(); ++v)
      mesh.positions[v] += float(std::clamp(steps[v], -kMostStep * edge, kMostStep * edge)) * mesh.normals[v];
    relax(plate.neighbours(), mesh);
  }
  std::vector<double> residuals;
  std::vector<uint8_t> seen(mesh.positions.size(), 0);
  for (const Contact& c : all) residuals.push_back(std::abs(c.away)), seen[c.vertex] = 1;
  if (!residuals.empty()) out.residual = quantile_of(residuals, 0.5);
  out.contacts = double(std::ranges::count(seen, 1)) / double(seen.size());
  return out;
}

}  // namespace vitrine
