#include "core/train/mesh_training.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/base/error.h"

namespace vitrine {

namespace {
constexpr double kMeshBeta1 = 0.9, kMeshBeta2 = 0.99;
constexpr int kMeshMixing = 20;  // passes of half a vertex and half its neighbours
}  // namespace

MeshTraining::MeshTraining(TriMesh mesh, float tolerance) {
  if (mesh.faces.empty()) return;
  shape_ = std::make_shared<ShapeMesh>(std::move(mesh), tolerance);
  m_.assign(shape_->mesh().positions.size(), 0.0);
  find_neighbours();
}

void MeshTraining::find_neighbours() {
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (const auto& f : shape_->mesh().faces)
    for (size_t c = 0; c < 3; ++c) edges.emplace_back(f[c], f[(c + 1) % 3]), edges.emplace_back(f[(c + 1) % 3], f[c]);
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  first_.assign(shape_->mesh().positions.size() + 1, 0);
  neighbours_.clear();
  for (const auto& [from, to] : edges) ++first_[from + 1], neighbours_.push_back(to);
  for (size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
}

void MeshTraining::descend(const std::vector<double>& grad, double rate) {
  if (!shape_ || grad.size() != m_.size()) return;
  std::vector<double> slope = grad, before;
  for (int pass = 0; pass < kMeshMixing; ++pass) {
    before = slope;
    for (size_t v = 0; v < slope.size(); ++v) {
      if (first_[v] == first_[v + 1]) continue;
      double sum = 0;
      for (uint32_t k = first_[v]; k < first_[v + 1]; ++k) sum += before[neighbours_[k]];
      slope[v] = 0.5 * (before[v] + sum / double(first_[v + 1] - first_[v]));
    }
  }
  // Of the vertices that are asked for anything: the size of a step does not depend on how much of the mesh a photo shows.
  double squares = 0;
  size_t asked = 0;
  for (double g : slope)
    if (g != 0) squares += g * g, ++asked;
  if (asked == 0 || !std::isfinite(squares)) return;
  squares /= double(asked);
  ++steps_;
  const double c1 = 1 / (1 - std::pow(kMeshBeta1, double(steps_))), c2 = 1 / (1 - std::pow(kMeshBeta2, double(steps_)));
  v_ = kMeshBeta2 * v_ + (1 - kMeshBeta2) * squares;
  TriMesh moved = shape_->mesh();
  for (size_t i = 0; i < m_.size(); ++i) {
    m_[i] = kMeshBeta1 * m_[i] + (1 - kMeshBeta1) * slope[i];
    moved.positions[i] += static_cast<float>(-rate * m_[i] * c1 / std::sqrt(v_ * c2)) * moved.normals[i];
  }
  shape_ = std::make_shared<ShapeMesh>(std::move(moved), shape_->tolerance());
}

void MeshTraining::save(ArchiveWriter& out) const {
  out.value(shape_ ? shape_->tolerance() : 0.f);
  out.array(shape_ ? std::span<const Vec3f>(shape_->mesh().positions) : std::span<const Vec3f>());
  out.array(shape_ ? std::span<const std::array<uint32_t, 3>>(shape_->mesh().faces) : std::span<const std::array<uint32_t, 3>>());
  out.array(std::span<const double>(m_));
  out.value(v_);
  out.value(steps_);
}

void MeshTraining::load(ArchiveReader& in) {
  *this = {};
  float tolerance = 0;
  TriMesh mesh;
  in.value(tolerance);
  in.array(mesh.positions);
  in.array(mesh.faces);
  in.array(m_);
  in.value(v_);
  in.value(steps_);
  if (!(tolerance > 0)) return;
  const bool vertices =
      std::ranges::all_of(mesh.faces, [&](const auto& f) { return std::ranges::max(f) < mesh.positions.size(); });
  if (!vertices || m_.size() != mesh.positions.size() || !std::isfinite(tolerance))
    throw Error(ErrorKind::Input, "a checkpoint is damaged",
                {.why = "the mesh of what stands out of solids does not hang together",
                 .hint = "the stage begins anew without it",
                 .code = "BAD_CHECKPOINT"});
  shape_ = std::make_shared<ShapeMesh>(std::move(mesh), tolerance);
  find_neighbours();
}

}  // namespace vitrine
