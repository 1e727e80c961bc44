#include "stages/tomography/tomography.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/scene/mesh/mesh_io.h"
#include "stages/page_text.h"
#include "stages/tomography/page_volume.h"
#include "stages/tomography/scan_file.h"
#include "stages/tomography/voxel_fit.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kWidestBeam = 0.95;  // sine of half the opening angle: beyond, the source stands next to the volume
constexpr double kCutOff = 0.05;      // absorption at the left or right border over the largest: the object leaves the picture
constexpr size_t kBytesPerPixel = 8;  // of all projections: the line integrals, those of the result

void check_source(const ScanFile& scan) {
  const ScanGeometry& g = scan.geometry;
  const SeenCylinder seen = seen_cylinder(g);
  if (!(seen.radius > 0 && seen.half_height > 0))
    throw Error(ErrorKind::Input, "no point is in the middle of all projections",
                {.where = scan.where,
                 .why = fmt::format("the detector is {} x {} {}, its offset {} and {}", g.width * g.pixel_size,
                                    g.height * g.pixel_size, g.unit, g.detector_offset.x, g.detector_offset.y),
                 .hint = "check pixel_size, detector_offset and the distances",
                 .code = "NOTHING_SEEN"});
  if (g.beam == Beam::Cone && seen.radius > kWidestBeam * g.source_distance)
    throw Error(ErrorKind::Input, "the source stands in the volume",
                {.where = scan.where,
                 .why = fmt::format("the projections see {:.4g} {} around the axis, the source is at {:.4g}", seen.radius, g.unit,
                                    g.source_distance),
                 .hint = "check pixel_size, source_distance and detector_distance: all have the same unit",
                 .code = "SOURCE_INSIDE"});
}

// Absorption at the left and right border: the object is wider than the detector, and the volume has errors near its border.
void warn_of_cut_objects(std::span<const ImageF> projections, StageContext& context) {
  double border = 0, largest = 0;
  for (const ImageF& p : projections)
    for (int y = 0; y < p.height(); ++y) {
      border = std::max(border, double(std::min(p.at(0, y), p.at(1, y))));
      border = std::max(border, double(std::min(p.at(p.width() - 1, y), p.at(p.width() - 2, y))));
      for (int x = 0; x < p.width(); ++x) largest = std::max(largest, double(p.at(x, y)));
    }
  if (border > kCutOff * largest)
    context.warning("OBJECT_CUT",
                    fmt::format("the object reaches over the border of the projections ({:.0f} % of the largest absorption "
                                "there): densities near the border of the volume are too high",
                                100 * border / largest));
}

struct Residual {
  double rms = 0, of_projections = 0, worst = 0;
  size_t worst_view = 0;
};

Residual residual(std::span<const ImageF> projections, std::span<const ImageF> fitted) {
  Residual out;
  double all = 0, energy = 0, count = 0;
  for (size_t v = 0; v < projections.size(); ++v) {
    double sum = 0;
    for (size_t i = 0; i < projections[v].pixel_count(); ++i) {
      const double p = double(projections[v].data()[i]), d = double(fitted[v].data()[i]) - p;
      sum += d * d, energy += p * p;
    }
    all += sum, count += double(projections[v].pixel_count());
    const double rms = std::sqrt(sum / double(projections[v].pixel_count()));
    if (rms > out.worst) out.worst = rms, out.worst_view = v;
  }
  out.rms = std::sqrt(all / count), out.of_projections = std::sqrt(all / energy);
  return out;
}

void check_memory(const VoxelGrid<float>& volume, const ScanGeometry& g, StageContext& context) {
  const size_t pixels = g.angles.size() * size_t(g.width) * size_t(g.height);
  const size_t needed = voxel_fit_bytes(volume) + kBytesPerPixel * pixels;
  if (context.max_memory_bytes() == 0 || needed <= context.max_memory_bytes()) return;
  throw Error(ErrorKind::Resource, "the volume needs more memory than --max-memory",
              {.why = fmt::format("{} MiB for {} x {} x {} voxels and {} projections", needed >> 20, volume.size[0],
                                  volume.size[1], volume.size[2], g.angles.size()),
               .hint = "--set voxels=... with fewer voxels",
               .code = "MEMORY"});
}

}  // namespace

void describe(Describer& d, TomographyConfig& c) {
  d.option("voxels", c.voxels, "Cells along x and y of the volume; 0 = two thirds of the width of a projection.").range(0, 2048);
  d.option("rounds", c.rounds, "How often every projection is fitted.").range(1, 1000);
  d.option("tv", c.tv, "Weight of the total variation of the density: more makes it smoother inside surfaces.").range(0, 100);
  d.option("iso", c.iso, "Density of the surface, 1 / unit of length; 0 = between the two most different classes.")
      .range(0, 1e12);
}

void run_tomography(const TomographyConfig& config, StageContext& context) {
  ScanFile scan = read_scan(context.input("scan"));
  const std::vector<ImageF> projections = read_projections(scan);
  const ScanGeometry& g = scan.geometry;
  check_source(scan);
  warn_of_cut_objects(projections, context);
  VoxelGrid<float> volume = seen_grid(g, config.voxels > 0 ? config.voxels : std::max(4, 2 * g.width / 3));
  check_memory(volume, g, context);
  const VoxelFitDesc fit{.rounds = config.rounds, .tv = config.tv, .checkpoint = context.scratch() / "fit.checkpoint"};
  fit_voxels(g, projections, volume, fit, [&](const FitRound& r) {
    context.progress({.fraction = 0.95 * (r.round - 1 + r.share) / config.rounds,
                      .text = fmt::format("round {}/{}  error {:.4f}", r.round, config.rounds, r.error),
                      .values = {{"round", double(r.round)}, {"error", r.error}}});
  });
  const double iso = config.iso > 0 ? config.iso : otsu_threshold(volume);
  const TriMesh surface = density_surface(volume, iso);
  const Residual left = residual(projections, projected(g, volume));
  const fs::path out = context.output() / "ct";
  make_folders(out);
  write_nrrd(out / "volume.nrrd", volume, g.unit);
  write_slices(out, volume, g.unit);
  write_volume_page(out / "page.html", volume, {.unit = g.unit, .iso = iso, .seen = seen_cylinder(g)}, context);
  if (surface.faces.empty())
    context.warning("NO_SURFACE", fmt::format("no density reaches {:.4g} / {}: surface.ply is missing", iso, g.unit));
  else
    write_mesh_ply(out / "surface.ply", surface);
  const Json report{{"projections", projections.size()},
                    {"size", {volume.size[0], volume.size[1], volume.size[2]}},
                    {"voxel", volume.cell},
                    {"unit", g.unit},
                    {"rounds", config.rounds},
                    {"residual",
                     {{"rms", left.rms},
                      {"of_projections", left.of_projections},
                      {"worst", {{"projection", scan.projections[left.worst_view].filename().string()}, {"rms", left.worst}}}}},
                    {"iso", iso},
                    {"faces", surface.faces.size()}};
  write_file(out / "report.json", readable(report));
  context.metric("residual", left.of_projections);
  context.summary(fmt::format("{} x {} x {} voxels of {:.4g} {}, {:.1f} % of the projections unexplained", volume.size[0],
                              volume.size[1], volume.size[2], volume.cell, g.unit, 100 * left.of_projections));
}

Stage tomography_stage() {
  StageInfo info{.name = "tomography",
                 .version = 1,
                 .summary = "X-ray projections of an object, as a volume of voxels",
                 .inputs = {{.name = "scan",
                             .artifact = false,
                             .doc = "Geometry, angles and pictures of the scan: a YAML file.",
                             .also = scan_pictures}},
                 .doing = "reconstructing the volume"};
  return make_stage<TomographyConfig>(std::move(info), run_tomography, [] {
    return std::map<std::string, std::string>{{"page", empty_page_digest("tomography")}};
  });
}

}  // namespace vitrine
