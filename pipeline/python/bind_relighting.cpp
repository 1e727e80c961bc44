// vitrine.Relighting: a scene under another light, like `vitrine relight`.
#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/render/relight/relit_painter.h"
#include "pipeline/python/arrays.h"
#include "pipeline/python/bindings.h"

namespace vitrine {

namespace {

struct Relighting {
  std::unique_ptr<RelitPainter> painter;
  uint64_t seed;
  std::mutex busy = {};
};

Environment environment_of(const FloatArray& map) {
  ImageF image = image_of(map, "environment");
  if (image.width() != 2 * image.height())
    throw Error(ErrorKind::Input, fmt::format("an environment must be 2:1, this one is {}x{}", image.width(), image.height()),
                {.where = "environment", .hint = "a lat-long map [h, 2 h, 3], first row +z", .code = "ENV_SHAPE"});
  for (float& v : image.data()) {
    if (!std::isfinite(v))
      throw Error(ErrorKind::Input, "an environment has texels that are not finite",
                  {.where = "environment", .hint = "numpy.nan_to_num(environment)", .code = "ENV_BAD_TEXELS"});
    v = std::max(v, 0.f);
  }
  return Environment(std::move(image));
}

}  // namespace

py::object relighting_of(const FinishedRun& run, const py::object& environment, double rotate,
                         const std::optional<std::string>& lights, uint64_t seed) {
  Lighting lighting;
  if (!environment.is_none()) lighting.environment = environment_of(environment.cast<FloatArray>());
  auto out = std::make_shared<Relighting>(nullptr, seed);
  {
    const py::gil_scoped_release others;
    RelitScene scene = run.relit();
    if (environment.is_none() && !lights) lighting.environment = scene.captured;
    lighting.environment = lighting.environment.rotated(rotate);
    if (lights) read_lamps(*lights, lighting);
    out->painter = std::make_unique<RelitPainter>(std::move(scene));
    out->painter->set_lighting(lighting, {.seed = seed});
  }
  return py::cast(out);
}

void bind_relighting(py::module_& m) {
  py::class_<RelitPicture, std::shared_ptr<RelitPicture>>(m, "RelitPicture", "A picture under another light.")
      .def_property_readonly(
          "linear", [](const RelitPicture& p) { return image_array(p.radiance); },
          "Radiance [h, w, 3], linear, in the units of the environment.")
      .def_property_readonly(
          "albedo", [](const RelitPicture& p) { return image_array(p.albedo); },
          "Albedo of the surface times coverage [h, w, 3], linear.")
      .def_property_readonly(
          "alpha", [](const RelitPicture& p) { return image_array(p.coverage); },
          "Coverage by the scene [h, w]; the rest shows the environment.");
  py::class_<Relighting, std::shared_ptr<Relighting>>(
      m, "Relighting", "A scene under one light (Scene.relight), with the surfels as they are in the folder.")
      .def(
          "render",
          [](Relighting& self, const View& camera, int samples, uint64_t frame) {
            if (samples < 1) throw usage_error("a picture needs at least one sample a pixel", "samples=64");
            const py::gil_scoped_release others;
            const std::lock_guard lock(self.busy);
            return std::make_shared<RelitPicture>(
                self.painter->picture(camera, {.samples = samples, .seed = mix64(self.seed, frame)}));
          },
          py::arg("camera"), py::arg("samples") = 64, py::arg("frame") = 0,
          "RelitPicture of this camera. `frame`: its number among the pictures of `vitrine relight`, for the same noise.")
      .def_property_readonly(
          "stops", [](const Relighting& self) { return exposure_of_scene(self.painter->lit()); },
          "Stops that make the surfaces middle grey in the mean: vitrine.develop(picture.linear, stops).");
  m.def(
      "develop", [](const FloatArray& linear, double stops) { return image_array(developed(image_of(linear, "linear"), stops)); },
      py::arg("linear"), py::arg("stops") = 0., "Linear radiance [h, w, 3] times 2^stops, clipped, as sRGB uint8 [h, w, 3].");
}

}  // namespace vitrine
