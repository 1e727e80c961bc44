// The module vitrine._vitrine: reads finished runs, renders, relights and differentiates them (README.md).
#include "core/foundation/base/parallel.h"
#include "pipeline/python/arrays.h"
#include "pipeline/python/bindings.h"

namespace vitrine {

namespace {

// Set once by bind_errors; lives as long as the interpreter.
PyObject* error_class = nullptr;

void set_python_error(const Error& e) {
  const py::object error = py::reinterpret_borrow<py::object>(error_class)(e.what());
  error.attr("kind") = std::string(name(e.kind()));
  error.attr("exit_code") = exit_code(e.kind());
  error.attr("message") = e.message();
  error.attr("where") = e.detail().where;
  error.attr("why") = e.detail().why;
  error.attr("hint") = e.detail().hint;
  error.attr("code") = e.detail().code;
  PyErr_SetObject(error_class, error.ptr());
}

}  // namespace

void bind_errors(py::module_& m) {
  error_class = PyErr_NewExceptionWithDoc(
      "vitrine.Error",
      "What failed, where, why, and what to try: the text that the programs print. Attributes: message, where, why, hint, code "
      "('NO_SCENE'), kind ('INPUT'), exit_code of the programs.",
      PyExc_RuntimeError, nullptr);
  if (error_class == nullptr) throw py::error_already_set();
  m.add_object("Error", py::reinterpret_borrow<py::object>(error_class));
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& e) {
      set_python_error(e);
    }
  });
}

}  // namespace vitrine

PYBIND11_MODULE(_vitrine, m) {
  if (__builtin_cpu_supports("avx2") == 0) throw pybind11::import_error("vitrine needs a processor with AVX2");
  m.doc() = "Native part of the package vitrine.";
  m.attr("__version__") = VITRINE_VERSION;
  vitrine::bind_errors(m);
  vitrine::bind_cameras(m);
  vitrine::bind_surfels(m);
  vitrine::bind_objects(m);
  vitrine::bind_relighting(m);
  vitrine::bind_scene(m);
  m.def("set_threads", &vitrine::set_thread_limit, pybind11::arg("threads"),
        "Threads of rendering, 0: all. Results do not depend on it.");
}
