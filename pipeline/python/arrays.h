// Arrays of numpy over memory of this library. No values are copied unless the name contains it; the owner outlives the array.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/ranges.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "core/foundation/base/error.h"
#include "core/foundation/math/rigid.h"
#include "core/scene/image/image.h"

namespace vitrine {

namespace py = pybind11;
using Sizes = std::vector<py::ssize_t>;

inline Error usage_error(std::string message, std::string hint) {
  return {ErrorKind::Usage, std::move(message), {.hint = std::move(hint), .code = "USAGE"}};
}

// Onto memory of the Python object `owner`, writable.
template <class T>
py::array_t<T> array_over(std::span<T> values, Sizes shape, py::handle owner) {
  return py::array_t<T>(std::move(shape), values.data(), owner);
}

// Takes the object; `values`, `shape` of the result: of the object that `view` returns.
template <class Held, class Values>
auto array_with(Held held, const Values& values, Sizes shape) {
  auto* kept = new Held(std::move(held));
  const py::capsule owner(kept, [](void* p) { delete static_cast<Held*>(p); });
  auto span = values(*kept);
  using T = std::remove_const_t<typename decltype(span)::element_type>;
  return py::array_t<T>(std::move(shape), span.data(), owner);
}

// [h, w, channels]; one channel: [h, w].
template <class T>
py::array_t<T> image_array(Image<T> image) {
  Sizes shape{image.height(), image.width()};
  if (image.channels() > 1) shape.push_back(image.channels());
  return array_with(
      std::move(image), [](const Image<T>& i) { return i.data(); }, std::move(shape));
}

template <class T>
py::array_t<T> vector_array(std::vector<T> values, Sizes shape) {
  return array_with(
      std::move(values), [](std::vector<T>& v) { return std::span<T>(v); }, std::move(shape));
}

inline py::array_t<double> row_array(const Vec3d& v) { return vector_array(std::vector<double>{v.x, v.y, v.z}, {3}); }

// [3, 3], row by row
inline py::array_t<double> matrix_array(const Mat3d& m) {
  std::vector<double> rows;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) rows.push_back(m(r, c));
  return vector_array(std::move(rows), {3, 3});
}

using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;
using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

// Throws Error{Usage} unless the array has this shape. `name`: "d_picture"
inline void require_shape(const py::array& array, const Sizes& shape, const char* name) {
  const Sizes is(array.shape(), array.shape() + array.ndim());
  if (is != shape)
    throw usage_error(fmt::format("{} must have the shape ({}), got ({})", name, fmt::join(shape, ", "), fmt::join(is, ", ")),
                      fmt::format("{}.shape", name));
}

// [h, w, 3]
inline ImageF image_of(const FloatArray& array, const char* name) {
  if (array.ndim() != 3 || array.shape(2) != 3 || array.size() == 0)
    throw usage_error(fmt::format("{} must be a picture [h, w, 3]", name), fmt::format("{}.shape", name));
  ImageF out(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), 3);
  std::copy_n(array.data(), array.size(), out.data().begin());
  return out;
}

}  // namespace vitrine
