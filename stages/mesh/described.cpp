#include <algorithm>
#include <cmath>

#include "stages/mesh/mesh.h"

namespace vitrine {

namespace {
// Of a closed surface, per thousand points.
constexpr double kClosedSeconds = 1, kClosedMib = 8;
}  // namespace

void describe(Describer& d, RegionDesc& c) {
  d.option("reach_rel", c.reach_rel,
           "Cameras that look at one place: sparse points, and surfels of glass and mirrors, count up to this times the median "
           "camera distance from it.")
      .range(0.05, 100);
  d.option("margin", c.margin, "Added on each side, relative to the longest side.").range(0, 2);
  d.option(
      "box", c.box,
      "The region itself: x0 y0 z0 x1 y1 z1 in the scene frame; empty = found from cameras, sparse points, glass and mirrors.");
}

void describe(Describer& d, MeshFusionConfig& c) {
  d.option("free_space_weight", c.free_space_weight,
           "Weight of a sample in front of the band, which carves what floats there; 0 = no carving.")
      .range(0, 10);
  d.option("memory_mb", c.memory_mb, "Memory of the volume in MiB; the voxel grows when it would not fit.").range(1, 1 << 20);
}

void describe(Describer& d, MeshCleanConfig& c) {
  d.option("min_component", c.min_component, "Connected pieces with a smaller share of the faces are removed.").range(0, 1);
  d.option("keep_components", c.keep_components, "Keep at most so many pieces, the largest; 0 = no limit.").range(0, 1e9);
  d.option("smooth_iterations", c.smooth_iterations, "Rounds of Taubin smoothing.").range(0, 1000);
  d.option("fill_holes", c.fill_holes, "Holes of at most so many edges are closed; 0 = none.").range(0, 100000);
}

void describe(Describer& d, MeshConfig& c) {
  d.choice(
      "method", c.method, {"fusion", "poisson", "both"},
      "Surface of mesh.ply: as the photos show it and open elsewhere (fusion), or closed by a Poisson surface (poisson), for "
      "printing, volumes and simulation of an object; both: the closed one as mesh/watertight.ply.");
  d.option("resolution", c.resolution, "Voxels along the longest side of the region.").range(8, 4096);
  d.option("voxel", c.voxel, "Edge of a voxel in scene units (the cameras' ring has radius 1); 0 = from the resolution.")
      .range(0, 10);
  d.option("faces", c.faces, "mesh.ply has at most about so many triangles.").range(4, 100000000);
  d.choice("backend", c.backend, {"reference", "cpu"}, "Rasteriser that renders the depth maps.");
  d.group("region", c.region, "Where the mesh is made.");
  d.group("fusion", c.fusion, "How depth maps become a distance field.");
  d.group("clean", c.clean, "What happens to the raw surface.");
}

Stage mesh_stage() {
  return make_stage<MeshConfig>(
      {.name = "mesh",
       .version = 16,
       .summary = "TSDF fusion of the diffuse layer's depth, marching cubes, repair, decimation",
       .inputs = {{.name = "sfm", .doc = "Cameras and sparse points."},
                  {.name = "optimize", .doc = "The diffuse layer and its training views."},
                  {.name = "objects", .optional = true, .doc = "Mirrors, whose depth is that of their shapes."}},
       .doing = "building the mesh",
       .cost = mesh_cost,
       .report = mesh_report()},
      run_mesh, [] {
        return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
      });
}

StageCost mesh_cost(const CostTerms& t) {
  const double scale = std::pow(t.number("mesh.resolution") / 256, 2), hulls = t.capture.masks ? 16 : 0;
  // A closed surface has a point per two faces, and several tetrahedra per point.
  const double points = t.text("mesh.method") == "fusion" ? 0 : 0.5e-3 * t.number("mesh.faces");  // thousands
  return stage_cost(8 + 4.5 * scale + hulls + kClosedSeconds * points, 0.5,
                    std::max((t.capture.masks ? 1.5 : 1) * (100 + 150 * scale), kClosedMib * points),
                    (t.text("mesh.method") == "both" ? 2 : 1) * 9e-5 * t.number("mesh.faces"));
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
  report.facts = {{"Geometry", "a mesh of {mesh.faces:n} triangles in {mesh.components:n} {mesh.components:piece,pieces}"},
                  {"Geometry", "a closed mesh of {watertight.faces:n} triangles"}};
  return report;
}

}  // namespace vitrine
