// Gradient descent of known shapes (core/scene/shape) on mirror reflections and silhouettes (core/render/model/shape_pass.h).
// Adam (Kingma and Ba 2015) with one second moment per group of parameters, so that parameters seen in no photo do not diverge;
// gradients are smoothed among neighbours first: profiles and meshes deform slowly.
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
  // Appends shapes; they start without history.
  void add(ShapeSet shapes);
  // Sets ShapeSet::Entry::layered of the entries of these objects.
  void set_layered(const std::map<uint16_t, double>& of_objects);
  // `gradients` [entry][parameter]; zero and non-finite ones are skipped.
  void descend(const std::vector<std::vector<double>>& gradients, const ShapeRates& rates);

  // Throws Error{Input} if the shapes read are unusable.
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
