// The descent of turned surfaces (core/model/shape_pass.h) along what mirrored pictures ask of them: the place of the axis, its
// direction, and each corner of the profile along its normal. Adam with one second moment for each of these three, so that a
// corner no photo looks at stays; gradients of neighbouring corners are mixed: a profile bends slowly.
#pragma once

#include <vector>

#include "core/model/shape_pass.h"
#include "core/optim/archive.h"
#include "core/shape/surface_of_revolution.h"

namespace vitrine {

struct ShapeRates {
  double origin = 0, axis = 0, profile = 0;  // scene units, radians, scene units per step
  double beside = 0;                         // of what stands out of them (mesh_training.h), scene units
};

class ShapeTraining {
 public:
  ShapeTraining() = default;
  explicit ShapeTraining(std::vector<SurfaceOfRevolution> shapes);

  const std::vector<SurfaceOfRevolution>& shapes() const { return shapes_; }
  bool empty() const { return shapes_.empty(); }
  // Gradients that are not finite are left out.
  void descend(const std::vector<std::vector<double>>& gradients, const ShapeRates& rates);

  void save(ArchiveWriter& out) const;
  void load(ArchiveReader& in);

 private:
  struct Moments {
    double m[4] = {}, v[2] = {};  // of origin and axis: two directions each
    double profile_v = 0;
    uint64_t steps = 0;
  };
  std::vector<SurfaceOfRevolution> shapes_;
  std::vector<Moments> moments_;                // [shape]
  std::vector<std::vector<double>> profile_m_;  // [shape][corner]
};

}  // namespace vitrine
