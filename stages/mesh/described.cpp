#include <cmath>

#include "stages/mesh/mesh.h"

namespace vitrine {

StageCost mesh_cost(const CostTerms& t) {
  const double scale = std::pow(t.number("mesh.resolution") / 256, 2), hulls = t.capture.masks ? 16 : 0;
  return stage_cost(8 + 4.5 * scale + hulls, 0.5, (t.capture.masks ? 1.5 : 1) * (100 + 150 * scale),
                    9e-5 * t.number("mesh.faces"));
}

StageReport mesh_report() {
  StageReport report{.file = "mesh/report.json"};
  report.figures = {
      ReportFigure{"Geometry", "mesh_border", "Open edges of the mesh", "%", 1, 0.04, 0.1,
                   "Share of the edges with a face on one side only. A room is open by nature.",
                   "Holes and ragged ends: places that few photos saw.", "mesh.boundary_edges"}
          .share("mesh.edges"),
      ReportFigure{"Geometry", "mesh_crossing", "Faces that cut each other", "", 0, 0, 100,
                   "Self-intersections of the cleaned mesh.", "Boolean operations and printing may stumble over them.",
                   "mesh.self_intersections"}
          .measured_on("mesh.faces", 1, "triangles"),
      ReportFigure{"Geometry", "mesh_nonmanifold", "Edges of more than two faces", "", 0, 0, 10,
                   "Non-manifold edges of the cleaned mesh.", "Some programs refuse such a mesh.", "mesh.nonmanifold_edges"}
          .measured_on("mesh.faces", 1, "triangles")};
  report.facts = {{"Geometry", "a mesh of {mesh.faces:n} triangles in {mesh.components:n} {mesh.components:piece,pieces}"}};
  return report;
}

}  // namespace vitrine
