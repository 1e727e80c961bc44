// vitrine.Scene: cameras, surfels, pictures and gradients of a finished run.
#include <algorithm>

#include <pybind11/stl.h>

#include "pipeline/python/arrays.h"
#include "pipeline/python/bindings.h"

namespace vitrine {

namespace {

struct Picture {
  ViewPicture view;
  ImageF alpha;
};

// True during its life.
struct Flag {
  explicit Flag(bool& flag) : flag_(flag) { flag_ = true; }
  ~Flag() { flag_ = false; }
  bool& flag_;
};

ImageF interleaved_picture(std::span<const float> planes, const Intrinsics& k) {
  ImageF out(k.width, k.height, 3);
  const size_t n = k.pixel_count();
  for (size_t i = 0; i < n; ++i)
    for (size_t c = 0; c < 3; ++c) out.data()[3 * i + c] = planes[c * n + i];
  return out;
}

std::shared_ptr<Picture> render(OpenScene& self, const View& camera) {
  const py::gil_scoped_release others;
  const std::lock_guard lock(self.busy);
  auto out =
      std::make_shared<Picture>(self.painter.picture(camera), ImageF(camera.intrinsics.width, camera.intrinsics.height, 1));
  std::ranges::copy(self.painter.frame().diffuse.plane(Aov::Alpha), out->alpha.data().begin());
  return out;
}

py::dict gradient(OpenScene& self, const View& camera, const py::object& d_picture) {
  const Intrinsics& k = camera.intrinsics;
  std::unique_lock lock(self.busy, std::defer_lock);
  {
    const py::gil_scoped_release others;
    lock.lock();
    if (self.differentiating) throw usage_error("a gradient within a gradient of the same scene", "another vitrine.open");
    if (!self.model) {
      ImageOptions options = self.painter.picture_options();
      options.composite.layer_images = false;
      self.model.emplace(options);
    }
    self.frame.differentiable = true;
    self.model->forward(self.painter.surfels(), camera, self.frame);
  }
  const Flag differentiating(self.differentiating);
  py::object given = d_picture;
  if (PyCallable_Check(given.ptr()) != 0) given = given(image_array(interleaved_picture(self.frame.srgb, k)));
  const FloatArray d = given.cast<FloatArray>();
  require_shape(d, {k.height, k.width, 3}, "d_picture");
  const size_t n = k.pixel_count();
  for (size_t i = 0; i < n; ++i)
    for (size_t c = 0; c < 3; ++c) self.frame.grad_srgb[c * n + i] = d.data()[3 * i + c];
  SplatScene grad = self.painter.surfels().zeros_like();
  {
    const py::gil_scoped_release others;
    self.model->backward(self.painter.surfels(), self.frame, grad);
  }
  py::dict out;
  for (const LayerKind kind : kAllLayers)
    if (grad.layer(kind).size() > 0) out[py::str(std::string(name(kind)))] = gradients_of(std::move(grad.layer(kind)));
  return out;
}

py::dict surfels_of(const ScenePointer& self) {
  py::dict out;
  SplatScene& all = self->painter.surfels();
  for (const LayerKind kind : kAllLayers)
    if (all.layer(kind).size() > 0) out[py::str(std::string(name(kind)))] = SurfelSet{self, &all.layer(kind)};
  if (all.opaque.size() > 0) out["opaque"] = SurfelSet{self, &all.opaque};
  return out;
}

const View& camera_of(const OpenScene& self, const std::string& name) {
  const auto found = std::ranges::find_if(self.views, [&](const View& v) { return v.name == name || v.stem() == name; });
  if (found == self.views.end())
    throw Error(ErrorKind::Input, fmt::format("'{}' has no camera in this scene", name),
                {.where = self.run.project().string(), .hint = "[c.name for c in scene.cameras]", .code = "NO_CAMERA"});
  return *found;
}

void bind_pictures(py::module_& m) {
  py::class_<Picture, std::shared_ptr<Picture>>(m, "Picture", "A rendered view, h rows of w pixels, float32.")
      .def_property_readonly(
          "srgb", [](const Picture& p) { return image_array(p.view.srgb); },
          "As shown: sRGB in [0, 1], gain of the camera applied [h, w, 3].")
      .def_property_readonly(
          "linear", [](const Picture& p) { return image_array(p.view.linear); },
          "Radiance before the gain [h, w, 3], linear Rec. 709.")
      .def_property_readonly(
          "depth", [](const Picture& p) { return image_array(p.view.zdepth); },
          "Along the camera's axis [h, w], scene units; 0 where alpha < 1/2.")
      .def_property_readonly(
          "normals", [](const Picture& p) { return image_array(p.view.normal_in_world); },
          "Unit normals in the world [h, w, 3]; 0 where alpha < 1/2.")
      .def_property_readonly(
          "alpha", [](const Picture& p) { return image_array(p.alpha); }, "Coverage by surfels [h, w].")
      .def_property_readonly(
          "rgb8",
          [](const Picture& p) {
            Image8 bytes(p.view.srgb.width(), p.view.srgb.height(), 3);
            std::ranges::transform(p.view.srgb.data(), bytes.data().begin(), [](float v) { return uint8_t(v * 255 + 0.5f); });
            return image_array(std::move(bytes));
          },
          "`srgb` as uint8 [h, w, 3]: the pixels of the PNG that `vitrine render` writes.");
}

}  // namespace

OpenScene::OpenScene(const fs::path& project, bool edited, const PictureDesc& desc)
    : run(project, edited), views(run.views(ViewChoice::All)), heldout(run.heldout()), painter(run.trained(), desc) {}

void bind_scene(py::module_& m) {
  bind_pictures(m);
  py::class_<OpenScene, ScenePointer>(m, "Scene", "A trained scene; vitrine.open makes it.")
      .def_property_readonly(
          "cameras", [](const OpenScene& s) { return s.views; }, "Cameras of the photos at their training size, sorted by name.")
      .def_readonly("heldout", &OpenScene::heldout, "Names of the photos that the training never saw.")
      .def("camera", &camera_of, py::arg("name"), py::return_value_policy::copy, "Camera of a photo, by its name or stem.")
      .def_property_readonly("surfels", &surfels_of,
                             "Sets of surfels: diffuse; reflection, transmittance and opaque (the opaque twin) if there are any.")
      .def_property_readonly(
          "objects", [](const OpenScene& s) { return objects_of(s.run); },
          "Table of glass, mirrors and coats: dictionaries with id, name, role, trust, shapes (kind and "
          "parameters, scene units).")
      .def_property_readonly(
          "mesh", [](const OpenScene& s) { return mesh_of(s.run); }, "Mesh, or None if none was extracted.")
      .def("render", &render, py::arg("camera"), "Picture of a camera: the pixels of `vitrine render`.")
      .def("gradient", &gradient, py::arg("camera"), py::arg("d_picture"),
           "Gradients of a loss by the raw values of the surfels: {set: {attribute: [n, width]}}.\n\n"
           "d_picture [h, w, 3]: dL/dsrgb; or a function of the picture (srgb [h, w, 3]) that returns it. The opaque twin takes "
           "no "
           "part in this picture.")
      .def(
          "relight",
          [](const OpenScene& s, const py::object& environment, double rotate, const std::optional<std::string>& lights,
             uint64_t seed) { return relighting_of(s.run, environment, rotate, lights, seed); },
          py::arg("environment") = py::none(), py::arg("rotate") = 0., py::arg("lights") = py::none(), py::arg("seed") = 1,
          "Relighting under a lat-long map [h, 2 h, 3] of linear radiance: first row +z, centre +x, rotated by degrees about +z, "
          "and the lamps of a YAML file. Without both: the light of the photos.");
  m.def(
      "open",
      [](const std::string& folder, bool edited, int samples, bool medium) {
        const py::gil_scoped_release others;
        return std::make_shared<OpenScene>(folder, edited, PictureDesc{.samples = samples, .medium = medium});
      },
      py::arg("folder"), py::arg("edited") = false, py::arg("samples") = 0, py::arg("medium") = true,
      "Scene of an output folder of `vitrine run`; edited: as `vitrine edit` left it; samples: rays of a rough pixel, 0: as "
      "trained; medium: with the water or haze of the photos.");
}

}  // namespace vitrine
