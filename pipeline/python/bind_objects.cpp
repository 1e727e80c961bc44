// The table of objects as dictionaries, and the mesh as numpy arrays.
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/objects/object_set.h"
#include "pipeline/python/arrays.h"
#include "pipeline/python/bindings.h"

namespace vitrine {

namespace {

// [n, width], over the memory of `self`.
template <class Row>
auto rows_over(std::vector<Row>& rows, py::ssize_t width, py::handle self) {
  using T = std::remove_reference_t<decltype(rows[0][0])>;
  return array_over(std::span<T>(rows.empty() ? nullptr : &rows[0][0], rows.size() * static_cast<size_t>(width)),
                    {static_cast<py::ssize_t>(rows.size()), width}, self);
}

py::dict parameters(const Plane& s) {
  py::dict d;
  d["kind"] = "plane", d["centre"] = row_array(s.centre), d["axes"] = matrix_array(s.axes);
  d["half"] = vector_array(std::vector<double>{s.half.x, s.half.y}, {2});
  return d;
}
py::dict parameters(const Box& s) {
  py::dict d;
  d["kind"] = "box", d["axes"] = matrix_array(s.axes), d["low"] = row_array(s.low), d["high"] = row_array(s.high);
  return d;
}
py::dict parameters(const SurfaceOfRevolution& s) {
  py::dict d;
  std::vector<double> profile;
  for (const Vec2d& p : s.profile) profile.insert(profile.end(), {p.x, p.y});
  d["kind"] = "surface_of_revolution", d["origin"] = row_array(s.origin), d["axis"] = row_array(s.axis);
  d["profile"] = vector_array(std::move(profile), {static_cast<py::ssize_t>(s.profile.size()), 2});
  return d;
}
py::dict parameters(const TriangleShape& s) {
  py::dict d;
  d["kind"] = "triangles", d["mesh"] = py::cast(std::make_shared<TriMesh>(s.mesh()));
  return d;
}

}  // namespace

py::list objects_of(const FinishedRun& run) {
  const ObjectSet set = read_objects(run.artifact("objects"));
  py::list out;
  for (const Object& o : set.objects) {
    py::list shapes;
    for (const ShapeSet::Entry& e : set.shapes.entries)
      if (e.object == o.id) shapes.append(std::visit([](const auto& s) { return parameters(s); }, e.shape));
    py::dict d;
    d["id"] = o.id, d["name"] = o.name, d["role"] = std::string(name(o.role)), d["trust"] = std::string(name(o.trust));
    d["shapes"] = shapes;
    out.append(d);
  }
  return out;
}

py::object mesh_of(const FinishedRun& run) {
  const auto artifact = run.artifact("mesh");
  if (!artifact) return py::none();
  return py::cast(std::make_shared<TriMesh>(read_mesh_ply(*artifact / "mesh" / "mesh.ply")));
}

void bind_objects(py::module_& m) {
  const auto mesh_of_self = [](const py::object& self) -> TriMesh& { return self.cast<TriMesh&>(); };
  py::class_<TriMesh, std::shared_ptr<TriMesh>>(m, "Mesh", "A triangle mesh in the scene's frame. Arrays are not copies.")
      .def_property_readonly(
          "vertices", [=](const py::object& self) { return rows_over(mesh_of_self(self).positions, 3, self); },
          "Positions [v, 3], scene units.")
      .def_property_readonly(
          "normals", [=](const py::object& self) { return rows_over(mesh_of_self(self).normals, 3, self); },
          "Unit normals [v, 3], or empty.")
      .def_property_readonly(
          "colors", [=](const py::object& self) { return rows_over(mesh_of_self(self).colors, 3, self); },
          "Linear RGB [v, 3], or empty.")
      .def_property_readonly(
          "faces", [=](const py::object& self) { return rows_over(mesh_of_self(self).faces, 3, self); },
          "Vertices of each triangle [f, 3], counter-clockwise seen from outside.")
      .def_property_readonly(
          "object_ids",
          [=](const py::object& self) {
            std::vector<uint16_t>& ids = mesh_of_self(self).object_ids;
            return array_over(std::span<uint16_t>(ids), {static_cast<py::ssize_t>(ids.size())}, self);
          },
          "Object of each vertex [v], 0: none; or empty.")
      .def("__repr__", [](const TriMesh& mesh) {
        return fmt::format("<vitrine.Mesh {} vertices, {} faces>", mesh.positions.size(), mesh.faces.size());
      });
}

}  // namespace vitrine
