// Set of 2D Gaussian surfels as structure of arrays: raw (pre-activation) values, one array per attribute row. Gradients and
// Adam moments have the same shape and also use SplatLayer.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/foundation/math/spherical_harmonics.h"
#include "core/scene/surfels/attributes.h"

namespace vitrine {

class SplatLayer {
 public:
  SplatLayer() : SplatLayer(LayerKind::Diffuse, 0, 0) {}
  SplatLayer(LayerKind kind, int sh_degree, size_t size) : kind_(kind), sh_degree_(sh_degree) { resize(size); }

  LayerKind kind() const { return kind_; }
  int sh_degree() const { return sh_degree_; }  // stored degree; shading may use a lower one
  size_t size() const { return size_; }

  // Floats per surfel; 0 if the layer does not own the attribute.
  size_t width(Attribute a) const {
    if (!has_attribute(kind_, a)) return 0;
    if (a == Attribute::ShRest) return 3 * (sh_coefficient_count(sh_degree_) - 1);
    return static_cast<size_t>(row(a).width);
  }
  // [size * width(a)], surfel-major. ShRest: coefficient-major inside a surfel, [k-1][rgb].
  std::span<float> values(Attribute a) { return data_[static_cast<size_t>(a)]; }
  std::span<const float> values(Attribute a) const { return data_[static_cast<size_t>(a)]; }
  float* at(Attribute a, size_t i) { return data_[static_cast<size_t>(a)].data() + i * width(a); }
  const float* at(Attribute a, size_t i) const { return data_[static_cast<size_t>(a)].data() + i * width(a); }

  // Object id of each surfel in the object table (core/scene/objects), 0 = none. Empty: unknown. Not an attribute: not trained,
  // absent in gradients.
  std::span<const uint16_t> object_ids() const { return object_ids_; }
  void set_object_ids(std::vector<uint16_t> ids) {
    VITRINE_CHECK(ids.empty() || ids.size() == size_, "{} ids of objects for {} surfels", ids.size(), size_);
    object_ids_ = std::move(ids);
  }

  // New surfels have raw values 0 and no object.
  void resize(size_t size) {
    size_ = size;
    for (const AttributeRow& r : kAttributes) data_[static_cast<size_t>(r.id)].resize(size * width(r.id), 0.f);
    if (!object_ids_.empty()) object_ids_.resize(size, 0);
  }
  void copy_surfel(size_t from, size_t to) {
    if (!object_ids_.empty()) object_ids_[to] = object_ids_[from];
    for (const AttributeRow& r : kAttributes)
      for (size_t c = 0, w = width(r.id); c < w; ++c) at(r.id, to)[c] = at(r.id, from)[c];
  }
  void fill(float value);
  SplatLayer zeros_like() const { return SplatLayer(kind_, sh_degree_, size_); }
  bool operator==(const SplatLayer&) const = default;

 private:
  LayerKind kind_;
  int sh_degree_;
  size_t size_ = 0;
  std::array<std::vector<float>, kAttributeCount> data_;
  std::vector<uint16_t> object_ids_;
};

// True if tau > 0.5: the surfel of a diffuse layer is glass.
bool is_glass(const SplatLayer& diffuse, size_t i);

}  // namespace vitrine
