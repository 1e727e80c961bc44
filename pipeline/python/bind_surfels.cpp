// vitrine.Surfels: the attributes of one set of surfels as numpy arrays, raw and in their units.
#include <cmath>

#include "core/scene/surfels/activation.h"
#include "pipeline/python/arrays.h"
#include "pipeline/python/bindings.h"

namespace vitrine {

namespace {

struct Property {
  const char* name;
  Attribute attribute;
  const char* doc;
};
constexpr Property kProperties[] = {
    {"positions", Attribute::Mean, "Centres [n, 3], scene units."},
    {"rotations", Attribute::Rotation, "Unit quaternions w x y z [n, 4]; the third column of the rotation is the normal."},
    {"scales", Attribute::LogScale, "Standard deviations along the two axes [n, 2], scene units."},
    {"opacities", Attribute::Opacity, "[n] in (0, 1)."},
    {"f0", Attribute::F0, "Reflectance at normal incidence [n, 3] in (0, 1)."},
    {"roughness", Attribute::Roughness, "[n] in (0, 1); GGX alpha = roughness^2."},
    {"k_s", Attribute::SpecularWeight, "Specular weight [n] in (0, 1)."},
    {"transmission", Attribute::Transmission, "Transmission tau [n] in (0, 1)."},
};

Sizes shape_of(const SplatLayer& layer, Attribute a) {
  const auto n = static_cast<py::ssize_t>(layer.size()), width = static_cast<py::ssize_t>(layer.width(a));
  return width == 1 ? Sizes{n} : Sizes{n, width};
}

void require_attribute(const SplatLayer& layer, const Property& p) {
  if (layer.width(p.attribute) == 0)
    throw usage_error(fmt::format("the {} surfels have no {}", name(layer.kind()), p.name), "scene.surfels[\"diffuse\"]");
}

py::array_t<float> values_of(const SurfelSet& set, const Property& p) {
  const SplatLayer& layer = *set.layer;
  require_attribute(layer, p);
  const auto raw = layer.values(p.attribute);
  std::vector<float> values(raw.begin(), raw.end());
  for (float& v : values) v = activated_value(row(p.attribute).activation, v);
  if (row(p.attribute).activation == Activation::Normalize)
    for (size_t i = 0; i < layer.size(); ++i) {
      const float* q = layer.at(p.attribute, i);
      const Quatf unit = normalized(Quatf{q[0], q[1], q[2], q[3]});
      for (const auto& [c, v] : {std::pair<size_t, float>{0, unit.w}, {1, unit.x}, {2, unit.y}, {3, unit.z}})
        values[4 * i + c] = v;
    }
  return vector_array(std::move(values), shape_of(layer, p.attribute));
}

void set_values(const SurfelSet& set, const Property& p, const FloatArray& array) {
  require_attribute(*set.layer, p);
  require_shape(array, shape_of(*set.layer, p.attribute), p.name);
  const Activation activation = row(p.attribute).activation;
  std::vector<float> raw(array.data(), array.data() + array.size());
  for (float& v : raw) {
    v = raw_value(activation, v);
    if (!std::isfinite(v)) throw usage_error(fmt::format("{} cannot have this value", p.name), std::string("allowed: ") + p.doc);
  }
  std::ranges::copy(raw, set.layer->values(p.attribute).begin());
}

py::array_t<float> normals_of(const SurfelSet& set) {
  const SplatLayer& layer = *set.layer;
  std::vector<float> normals;
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* q = layer.at(Attribute::Rotation, i);
    const Vec3f n = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})).c2;
    normals.insert(normals.end(), {n.x, n.y, n.z});
  }
  return vector_array(std::move(normals), {static_cast<py::ssize_t>(layer.size()), 3});
}

// Radiance of the constant term, linear.
py::array_t<float> colors_of(const SurfelSet& set) {
  const auto dc = set.layer->values(Attribute::ShDc);
  std::vector<float> colors(dc.begin(), dc.end());
  for (float& v : colors) v = std::max(0.f, 0.5f + kShDc * v);
  return vector_array(std::move(colors), shape_of(*set.layer, Attribute::ShDc));
}

void set_colors(const SurfelSet& set, const FloatArray& array) {
  require_shape(array, shape_of(*set.layer, Attribute::ShDc), "colors");
  const auto dc = set.layer->values(Attribute::ShDc);
  for (size_t i = 0; i < dc.size(); ++i) {
    if (!(array.data()[i] >= 0) || !std::isfinite(array.data()[i]))
      throw usage_error("colors cannot have this value", "linear radiance, 0 or more");
    dc[i] = (array.data()[i] - 0.5f) / kShDc;
  }
}

py::dict raw_of(const py::object& self) {
  SplatLayer& layer = *self.cast<SurfelSet&>().layer;
  py::dict out;
  for (const AttributeRow& r : kAttributes)
    if (layer.width(r.id) > 0)
      out[py::str(std::string(r.name))] = array_over(
          layer.values(r.id), {static_cast<py::ssize_t>(layer.size()), static_cast<py::ssize_t>(layer.width(r.id))}, self);
  return out;
}

}  // namespace

py::dict gradients_of(SplatLayer gradients) {
  py::dict out;
  for (const AttributeRow& r : kAttributes) {
    const auto width = static_cast<py::ssize_t>(gradients.width(r.id));
    if (width == 0) continue;
    const auto values = gradients.values(r.id);
    out[py::str(std::string(r.name))] =
        vector_array(std::vector<float>(values.begin(), values.end()), {static_cast<py::ssize_t>(gradients.size()), width});
  }
  return out;
}

void bind_surfels(py::module_& m) {
  py::class_<SurfelSet> surfels(
      m, "Surfels",
      "2D Gaussian surfels of one set. Properties are copies in the units given; assign to them to change the scene, which the "
      "next picture shows. `raw` has the values that are trained, without a copy.");
  surfels.def("__len__", [](const SurfelSet& s) { return s.layer->size(); })
      .def_property_readonly(
          "raw", &raw_of,
          "Dictionary of writable arrays [n, width] over the memory of the scene: mean, rotation (any length), "
          "log_scale, opacity, f0, roughness, specular_weight, transmission (before the sigmoid), sh_dc, "
          "sh_rest (spherical harmonics). Gradients have the same names and shapes.")
      .def_property("colors", &colors_of, &set_colors,
                    "Radiance of the constant term [n, 3], linear, 0 or more; raw['sh_rest'] adds what depends on the direction.")
      .def_property_readonly("normals", &normals_of, "Unit normals [n, 3]; their sign has no meaning. Set by `rotations`.")
      .def_property_readonly(
          "object_ids",
          [](const SurfelSet& s) {
            const auto ids = s.layer->object_ids();
            return vector_array(std::vector<uint16_t>(ids.begin(), ids.end()), {static_cast<py::ssize_t>(ids.size())});
          },
          "Object of each surfel [n], 0: none; empty: unknown.")
      .def_property_readonly("sh_degree", [](const SurfelSet& s) { return s.layer->sh_degree(); });
  for (const Property& p : kProperties)
    surfels.def_property(p.name, py::cpp_function([&p](const SurfelSet& s) { return values_of(s, p); }),
                         py::cpp_function([&p](const SurfelSet& s, const FloatArray& values) { set_values(s, p, values); }),
                         p.doc);
}

}  // namespace vitrine
