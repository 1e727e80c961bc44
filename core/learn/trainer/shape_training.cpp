#include "core/learn/trainer/shape_training.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>

#include "core/foundation/base/json.h"
#include "core/scene/shape/shape_file.h"

namespace vitrine {

namespace {

constexpr double kBeta1 = 0.9, kBeta2 = 0.99;

// Mean square of the non-zero gradients of a group: the step size does not depend on how many parameters a photo sees.
double mean_square(std::span<const double> grad) {
  double squares = 0;
  size_t nonzero = 0;
  for (const double g : grad)
    if (g != 0) squares += g * g, ++nonzero;
  return nonzero > 0 ? squares / double(nonzero) : 0;
}

}  // namespace

ShapeTraining::Moments::Moments(const Shape& shape)
    : first(parameter_count(shape), 0.0), second(parameter_groups(shape).size(), 0.0) {}

void ShapeTraining::add(ShapeSet shapes) {
  if (shapes.entries.empty()) return;
  ShapeSet all = set_ ? *set_ : ShapeSet{};
  for (const ShapeSet::Entry& e : shapes.entries) moments_.emplace_back(e.shape);
  all.append(std::move(shapes));
  set_ = std::make_shared<const ShapeSet>(std::move(all));
}

Shape ShapeTraining::stepped(const Shape& shape, std::vector<double> grad, const ShapeRates& rates, Moments& moments) {
  smooth(shape, grad);
  const std::vector<ParameterGroup> groups = parameter_groups(shape);
  std::vector<double> squares;
  double sum = 0;
  size_t at = 0;
  for (const ParameterGroup& g : groups) {
    sum += squares.emplace_back(mean_square({grad.data() + at, g.count}));
    at += g.count;
  }
  if (!std::isfinite(sum) || !(sum > 0)) return shape;  // not visible in the picture
  ++moments.steps;
  const double c1 = 1 / (1 - std::pow(kBeta1, double(moments.steps))), c2 = 1 / (1 - std::pow(kBeta2, double(moments.steps)));
  at = 0;
  for (size_t k = 0; k < groups.size(); ++k) {
    double& second = moments.second[k];
    second = kBeta2 * second + (1 - kBeta2) * squares[k];
    const double rate = groups[k].scale * (groups[k].unit == ParameterUnit::Angle ? rates.angle : rates.length);
    const double per_moment = second > 0 ? rate * c1 / std::sqrt(second * c2) : 0;
    for (const size_t end = at + groups[k].count; at < end; ++at) {
      double& first = moments.first[at];
      first = kBeta1 * first + (1 - kBeta1) * grad[at];
      grad[at] = -per_moment * first;
    }
  }
  return moved(shape, grad);
}

void ShapeTraining::descend(const std::vector<std::vector<double>>& gradients, const ShapeRates& rates) {
  if (!set_ || gradients.size() != moments_.size()) return;
  auto next = std::make_shared<ShapeSet>(*set_);
  for (size_t k = 0; k < moments_.size(); ++k)
    next->entries[k].shape = stepped(set_->entries[k].shape, gradients[k], rates, moments_[k]);
  set_ = std::move(next);
}

void ShapeTraining::set_layered(const std::map<uint16_t, double>& of_objects) {
  if (!set_) return;
  auto next = std::make_shared<ShapeSet>(*set_);
  for (ShapeSet::Entry& e : next->entries)
    if (const auto found = of_objects.find(e.object); found != of_objects.end()) e.layered = found->second;
  set_ = std::move(next);
}

void ShapeTraining::transfer(Archive& archive) {
  std::vector<TriMesh> meshes;
  const std::string written =
      write_shapes(set_ ? *set_ : ShapeSet{}, [&](size_t, const TriMesh& mesh) { meshes.push_back(mesh); }).dump();
  std::vector<char> text(written.begin(), written.end());
  archive.array(text);
  const auto transfer_mesh = [&](TriMesh& mesh) {
    archive.array(mesh.positions);
    archive.array(mesh.faces);
  };
  if (archive.reads()) {
    *this = {};
    try {
      add(read_shapes(nlohmann::json::parse(text), [&](size_t) {
        TriMesh mesh;
        transfer_mesh(mesh);
        return mesh;
      }));
    } catch (const nlohmann::json::exception&) {
      archive.fail("its shapes cannot be read");
    } catch (const std::domain_error& e) {
      archive.fail(e.what());
    }
  } else {
    for (TriMesh& mesh : meshes) transfer_mesh(mesh);
  }
  for (Moments& m : moments_) {
    const size_t parameters = m.first.size(), groups = m.second.size();
    archive.array(m.first);
    archive.array(m.second);
    archive.value(m.steps);
    if (m.first.size() != parameters || m.second.size() != groups) archive.fail("its shapes have other parameters");
  }
}

}  // namespace vitrine
