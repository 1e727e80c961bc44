// vitrine.Camera: a calibrated view, from numpy matrices.
#include <cmath>

#include <pybind11/stl.h>

#include "pipeline/python/arrays.h"
#include "pipeline/python/bindings.h"

namespace vitrine {

namespace {

constexpr double kNotARotation = 1e-4;  // largest error of a product of two columns

Rigid rigid_of(const DoubleArray& m) {
  require_shape(m, {4, 4}, "cam_from_world");
  const auto at = m.unchecked<2>();
  const auto column = [&](py::ssize_t c) { return Vec3d{at(0, c), at(1, c), at(2, c)}; };
  const Mat3d r{column(0), column(1), column(2)};
  double error = 0;
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) error = std::max(error, std::abs((transposed(r) * r)(i, j) - (i == j ? 1 : 0)));
  if (!(error < kNotARotation) || determinant(r) < 0 || !std::isfinite(length(column(3))))
    throw usage_error("cam_from_world is no rigid motion: its left 3x3 part must be a rotation without scale or mirror",
                      "the inverse of a pose (camera to world), camera axes x right, y down, z forward");
  return {r, column(3)};
}

View view_of(int width, int height, double fx, double fy, double cx, double cy, const DoubleArray& cam_from_world,
             const std::array<double, 3>& gain, const std::string& name) {
  if (width < 1 || height < 1 || std::max(width, height) > kMaxPictureSide || !(fx > 0) || !(fy > 0) ||
      !std::isfinite(fx + fy + cx + cy))
    throw usage_error(fmt::format("no camera has {}x{} pixels and the focal lengths {} and {}", width, height, fx, fy),
                      fmt::format("sides of 1 to {} pixels, focal lengths above 0, in pixels", kMaxPictureSide));
  return {name, {width, height, fx, fy, cx, cy}, rigid_of(cam_from_world), {gain[0], gain[1], gain[2]}};
}

py::array_t<double> pose_array(const Rigid& pose) {
  std::vector<double> rows;
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) rows.push_back(pose.rotation(r, c));
    rows.push_back(pose.translation[r]);
  }
  rows.insert(rows.end(), {0, 0, 0, 1});
  return vector_array(std::move(rows), {4, 4});
}

}  // namespace

void bind_cameras(py::module_& m) {
  py::class_<View>(m, "Camera",
                   "A pinhole camera in the scene's frame (ring of the photos' cameras = 1, up = +z).\n\n"
                   "Axes of the camera: x right, y down, z forward. The centre of the first pixel is (0.5, 0.5).")
      .def(py::init(&view_of), py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"),
           py::arg("cam_from_world"), py::arg("gain") = std::array<double, 3>{1, 1, 1}, py::arg("name") = "",
           "Size, focal lengths and principal point in pixels; cam_from_world [4, 4]: world to camera; gain: factors of the "
           "linear picture, RGB.")
      .def_readonly("name", &View::name, "Name of the photo, or as given.")
      .def_property_readonly(
          "width", [](const View& v) { return v.intrinsics.width; }, "Pixels.")
      .def_property_readonly(
          "height", [](const View& v) { return v.intrinsics.height; }, "Pixels.")
      .def_property_readonly(
          "K",
          [](const View& v) {
            const Intrinsics& k = v.intrinsics;
            return matrix_array({{k.fx, 0, 0}, {0, k.fy, 0}, {k.cx, k.cy, 1}});
          },
          "Matrix of the intrinsics [3, 3], pixels.")
      .def_property_readonly(
          "cam_from_world", [](const View& v) { return pose_array(v.cam_from_world); }, "[4, 4]")
      .def_property_readonly(
          "world_from_cam", [](const View& v) { return pose_array(inverse(v.cam_from_world)); }, "[4, 4]")
      .def_property_readonly(
          "position", [](const View& v) { return row_array(v.centre_in_world()); }, "Centre of the camera [3], scene units.")
      .def_property_readonly(
          "gain", [](const View& v) { return row_array(v.gain); },
          "Exposure and white balance of the photo [3]: linear photo = gain * radiance.")
      .def(
          "resized",
          [](View v, int width, int height) {
            if (width < 1 || height < 1 || std::max(width, height) > kMaxPictureSide)
              throw usage_error(fmt::format("no picture has {}x{} pixels", width, height), "camera.resized(640, 480)");
            v.intrinsics = covering(v.intrinsics, width, height);
            return v;
          },
          py::arg("width"), py::arg("height"),
          "The same camera at this size, like `vitrine render --size`: square pixels, cropped.")
      .def("__repr__", [](const View& v) {
        return fmt::format("<vitrine.Camera '{}' {}x{}>", v.name, v.intrinsics.width, v.intrinsics.height);
      });
}

}  // namespace vitrine
