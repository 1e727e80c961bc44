// The descent of known shapes (core/scene/shape) along the gradients of mirrored pictures and silhouettes (core/render/model/shape_pass.h).
// Adam (Kingma and Ba 2015) with one second moment for each group of parameters, so that a part that no photo looks at does not
// run away; gradients are mixed among neighbours first: profiles and meshes bend slowly.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "core/learn/optim/archive.h"
#include "core/scene/shape/shape_set.h"

namespace vitrine {

struct ShapeRates {
  double length = 0, angle = 0;  // scene units, radians per step: by ParameterUnit
};

class ShapeTraining {
 public:
  const std::shared_ptr<const ShapeSet>& set() const { return set_; }  // nullptr: no shape is known
  // More shapes, behind those that are there: they start without history.
  void add(ShapeSet shapes);
  // ShapeSet::Entry::layered of the entries of these objects.
  void set_layered(const std::map<uint16_t, double>& of_objects);
  // `gradients` [entry][parameter]; those that are zero or not finite are left out.
  void descend(const std::vector<std::vector<double>>& gradients, const ShapeRates& rates);

  // Throws Error{Input} when shapes that are read are unusable.
  void transfer(Archive& archive);

 private:
  struct Moments {
    std::vector<double> first;   // [parameter]
    std::vector<double> second;  // [group]
    uint64_t steps = 0;
    explicit Moments(const Shape& shape);
  };
  static Shape stepped(const Shape& shape, std::vector<double> grad, const ShapeRates& rates, Moments& moments);

  std::shared_ptr<const ShapeSet> set_;
  std::vector<Moments> moments_;  // [entry]
};

}  // namespace vitrine
