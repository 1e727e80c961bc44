#include "core/scene/mesh/poisson_cgal.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <memory>
#include <streambuf>
#include <utility>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Poisson_reconstruction_function.h>
#include <CGAL/property_map.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/scene/mesh/tetrahedra_surface.h"

namespace vitrine {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Oriented = std::pair<Kernel::Point_3, Kernel::Vector_3>;
using Function = CGAL::Poisson_reconstruction_function<Kernel>;

constexpr size_t kPointsPerStep = 1024;
constexpr double kBoxMargin = 0.05;  // of the diagonal: what is solid beyond this box around the points is cut off
constexpr double kInsideBox = 0.95;  // of that box is solid: the points enclose the air of a room

// CGAL prints counts of cells to std::cerr, whatever the caller wants.
class QuietStandardError {
 public:
  QuietStandardError() : kept_(std::cerr.rdbuf(&nothing_)) {}
  ~QuietStandardError() { std::cerr.rdbuf(kept_); }
  QuietStandardError(const QuietStandardError&) = delete;
  QuietStandardError& operator=(const QuietStandardError&) = delete;

 private:
  class Nothing : public std::streambuf {
    int overflow(int c) override { return c == traits_type::eof() ? 0 : c; }
  };
  Nothing nothing_;
  std::streambuf* kept_;
};

// CGAL copies its visitor, hence the pointer.
struct Insertions {
  size_t* count;
  size_t points;
  const std::function<void(double)>* progress;
  void before_insertion() const {
    if (++*count % kPointsPerStep == 0) (*progress)(static_cast<double>(*count) / static_cast<double>(points));
  }
};

std::vector<Oriented> usable(std::span<const Vec3f> points, std::span<const Vec3f> normals) {
  std::vector<Oriented> out;
  out.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3d p = cast<double>(points[i]), n = cast<double>(normals[i]);
    const double len = length(n);
    if (!std::isfinite(p.x + p.y + p.z) || !(len > 0) || !std::isfinite(len)) continue;
    out.emplace_back(Kernel::Point_3(p.x, p.y, p.z), Kernel::Vector_3(n.x / len, n.y / len, n.z / len));
  }
  return out;
}

Tetrahedra tetrahedra_of(const Function& function) {
  const auto& triangulation = function.tr();
  Tetrahedra out;
  out.positions.reserve(triangulation.number_of_vertices());
  out.values.reserve(triangulation.number_of_vertices());
  for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end(); ++v) {
    v->index() = static_cast<unsigned>(out.positions.size());
    out.positions.push_back({v->point().x(), v->point().y(), v->point().z()});
    out.values.push_back(v->f());
  }
  out.cells.reserve(triangulation.number_of_finite_cells());
  for (auto c = triangulation.finite_cells_begin(); c != triangulation.finite_cells_end(); ++c)
    out.cells.push_back({c->vertex(0)->index(), c->vertex(1)->index(), c->vertex(2)->index(), c->vertex(3)->index()});
  return out;
}

Error no_closed_surface(std::string why, std::string hint) {
  return Error(ErrorKind::Input, "no closed surface goes through the points",
               {.why = std::move(why), .hint = std::move(hint), .code = "NOT_CLOSED"});
}

// Points with their box and their spacing, were they spread over a square of its diagonal.
struct Cloud {
  explicit Cloud(const std::vector<Oriented>& points) : oriented(points) {
    for (const auto& [p, n] : points) box.extend({p.x(), p.y(), p.z()});
    diagonal = length(box.high - box.low);
    spacing = diagonal / std::sqrt(static_cast<double>(points.size()));
  }
  const std::vector<Oriented>& oriented;
  Bounds3 box;
  double diagonal = 0, spacing = 0;
};

// The indicator function of the points: positive on the side of their normals, whatever sign CGAL gave it.
class Indicator {
 public:
  Indicator(const Cloud& cloud, const std::function<void(double)>& progress) {
    using Solver = CGAL::Eigen_solver_traits<Eigen::ConjugateGradient<CGAL::Eigen_sparse_symmetric_matrix<double>::EigenType>>;
    const std::vector<Oriented>& points = cloud.oriented;
    const Insertions visitor{&inserted_, points.size(), &progress};
    const QuietStandardError quiet;
    function_ = std::make_unique<Function>(points.begin(), points.end(), CGAL::First_of_pair_property_map<Oriented>(),
                                           CGAL::Second_of_pair_property_map<Oriented>(), visitor);
    if (function_->tr().dimension() < 3 || !function_->compute_implicit_function(Solver(), visitor))
      throw no_closed_surface("the Poisson equation has no solution: the points may lie in one plane",
                              "mesh.method fusion needs no closed surface");
    double vote = 0;
    for (const auto& [p, n] : points) vote += (*function_)(p + cloud.spacing * n) > (*function_)(p - cloud.spacing * n) ? 1 : -1;
    sign_ = vote < 0 ? -1 : 1;
  }

  double at(const Vec3d& p) const { return sign_ * (*function_)(Kernel::Point_3(p.x, p.y, p.z)); }
  Tetrahedra tetrahedra() const {
    Tetrahedra out = tetrahedra_of(*function_);
    for (double& v : out.values) v *= sign_;
    return out;
  }

 private:
  size_t inserted_ = 0;
  std::unique_ptr<Function> function_;
  double sign_ = 1;
};

// Points on the faces of the box around the points where it is solid, with normals that point out of the box; their share of all.
std::pair<std::vector<Oriented>, double> cut_through(const Indicator& indicator, const Cloud& cloud) {
  const Vec3d grow = kBoxMargin * cloud.diagonal * Vec3d{1, 1, 1};
  const Vec3d low = cloud.box.low - grow, size = cloud.box.high + grow - low;
  const double area = 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
  const double step = std::sqrt(area / static_cast<double>(cloud.oriented.size()));
  std::vector<Oriented> out;
  double all = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int columns = std::max(1, static_cast<int>(size[u] / step)), rows = std::max(1, static_cast<int>(size[v] / step));
    for (int side = 0; side < 2; ++side)
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
          Vec3d p = low, n{};
          p[axis] += side * size[axis];
          p[u] += size[u] * (x + 0.5) / columns;
          p[v] += size[v] * (y + 0.5) / rows;
          n[axis] = side == 0 ? -1 : 1;
          all += 1;
          if (indicator.at(p) < 0) out.emplace_back(Kernel::Point_3(p.x, p.y, p.z), Kernel::Vector_3(n.x, n.y, n.z));
        }
  }
  const double share = static_cast<double>(out.size()) / all;
  return {std::move(out), share};
}

}  // namespace

TriMesh poisson_surface(std::span<const Vec3f> points, std::span<const Vec3f> normals, PoissonReport* report,
                        const std::function<void(double)>& progress) {
  VITRINE_CHECK(points.size() == normals.size(), "{} points, {} normals", points.size(), normals.size());
  PoissonReport unused, &r = report ? *report : unused;
  r = {};
  const auto report_progress = [&](double f) {
    if (progress) progress(std::min(f, 1.0));
  };
  const std::vector<Oriented> input = usable(points, normals);
  r.points = input.size();
  if (r.points < kLeastPoissonPoints)
    throw no_closed_surface(fmt::format("{} points with a normal, at least {} are needed", r.points, kLeastPoissonPoints),
                            "a finer voxel (mesh.resolution) gives more points");
  const Cloud cloud(input);
  auto indicator = std::make_unique<Indicator>(cloud, [&](double f) { report_progress(0.5 * f); });
  auto [joined, solid] = cut_through(*indicator, cloud);
  r.inwards = solid > kInsideBox;
  r.cut_points = r.inwards ? 0 : joined.size();
  if (r.cut_points > 0) {
    joined.insert(joined.begin(), input.begin(), input.end());
    indicator.reset();  // one triangulation in memory
    indicator = std::make_unique<Indicator>(Cloud(joined), [&](double f) { report_progress(0.5 + 0.5 * f); });
  }
  Tetrahedra tetrahedra = indicator->tetrahedra();
  r.vertices = tetrahedra.positions.size();
  if (r.inwards)
    for (double& v : tetrahedra.values) v = -v;
  TriMesh mesh = zero_level(tetrahedra);
  if (!mesh_report(mesh).closed())
    throw no_closed_surface("the surface leaves the space around the points: their normals contradict each other",
                            "mesh.method fusion needs no closed surface");
  if (r.inwards)
    for (auto& f : mesh.faces) std::swap(f[0], f[1]);
  return mesh;
}

}  // namespace vitrine
