// The descent of what stands out of turned surfaces (core/model/shape_mesh.h) along what mirrored pictures ask of it: each vertex
// along its normal. Adam with one second moment for the whole mesh; gradients of neighbours are mixed, so that it bends slowly
// and what no photo looks at moves with what is beside it.
#pragma once

#include <memory>
#include <vector>

#include "core/model/shape_mesh.h"
#include "core/optim/archive.h"

namespace vitrine {

class MeshTraining {
 public:
  MeshTraining() = default;
  MeshTraining(TriMesh mesh, float tolerance);

  const std::shared_ptr<const ShapeMesh>& shape() const { return shape_; }  // nullptr: there is none
  // `grad` [vertex]; none, or one that is not finite, is left out. `rate`: scene units.
  void descend(const std::vector<double>& grad, double rate);

  void save(ArchiveWriter& out) const;
  void load(ArchiveReader& in);

 private:
  void find_neighbours();

  std::shared_ptr<const ShapeMesh> shape_;
  std::vector<uint32_t> first_, neighbours_;  // [vertex + 1], of the vertices
  std::vector<double> m_;                     // [vertex]
  double v_ = 0;
  uint64_t steps_ = 0;
};

}  // namespace vitrine
