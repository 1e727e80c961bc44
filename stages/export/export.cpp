#include "stages/export/export.h"

#include <set>
#include <sstream>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/chart.h"
#include "core/scene/camera/scale_bar_length.h"

namespace vitrine {
void describe(Describer& d, ExportConfig& c) {
  d.option("formats", c.formats, "Formats to write; the stage's README lists what each holds and loses.")
      .choices(export_format_names());
  d.choice("axes", c.axes, kExportAxesWords,
           "Handedness and up axis of the files: right or left, z or y. GLB is always rhyu, USD always right-handed; the COLMAP "
           "copy stays as it is.");
  d.option("scale", c.scale,
           "File units per scene unit (the radius of the camera ring); 0 = metres where the scene knows them, else 1.")
      .range(0, 1e6);
  d.option("scale_bar", c.scale_bar,
           "A scale bar in the picture instead of `scale`, files in metres: its two ends in two or more photos and its length, "
           "\"photo:x1,y1,x2,y2 photo:x1,y1,x2,y2 = 5cm\" in pixels of the undistorted photos; empty: none.");
  d.option("scale_points", c.scale_points,
           "Two points of the scene instead of `scale`, files in metres: their places and the length between them, "
           "\"x,y,z x,y,z 24cm\", as the page of `vitrine view` writes it; empty: none.");
  d.option("texture_size", c.texture_size,
           "Side of the baked textures in texels; 0 = four texels per edge of the mesh, a power of two.")
      .range(0, 8192);
}

std::string problem(const ExportConfig& config) {
  std::set<std::string_view> seen;
  for (const std::string& name : config.formats)
    if (!seen.insert(name).second) return "formats: '" + name + "' is listed twice";
  std::vector<std::string_view> units;
  if (config.scale > 0) units.push_back("scale");
  if (!config.scale_bar.empty()) units.push_back("scale_bar");
  if (!config.scale_points.empty()) units.push_back("scale_points");
  if (units.size() > 1) return fmt::format("{} and {} both give the unit: leave one of them out", units[0], units[1]);
  return {};
}

namespace {

Error without_albedo(const ExportFormat& format) {
  return Error(ErrorKind::Input, fmt::format("the format {} needs the decompose stage", format.name),
               {.why = "it holds albedo, and the colours as trained have the photos' light in them",
                .hint = "vitrine run PROJECT --to decompose, or a format without albedo, as ply-3dgs",
                .code = "NO_ALBEDO"});
}

}  // namespace

void run_export(const ExportConfig& config, StageContext& context) {
  ExportSettings settings{.axes = config.axes, .scale = config.scale, .texture_size = config.texture_size};
  if (!config.scale_bar.empty()) {
    const fs::path sfm = context.input("sfm");
    const ScaleBarLength bar = scale_bar_length(parse_scale_bar(config.scale_bar), photo_cameras(sfm), read_passes(sfm));
    settings.scale = bar.metres_per_unit;
    settings.scale_note = scale_bar_text(bar);
    context.metric("metres_per_unit", bar.metres_per_unit);
    context.metric("scale_bar_error_px", bar.error_px);
  }
  if (!config.scale_points.empty()) {
    const ScalePoints points = parse_scale_points(config.scale_points);
    settings.scale = points.length_m / points.scene_units();
    settings.scale_note = fmt::format("one unit of the scene is {:.4g} m, by two points that are {:.4g} units apart",
                                      settings.scale, points.scene_units());
    context.metric("metres_per_unit", settings.scale);
  }
  ExportSource source({.sfm = context.input("sfm"),
                       .optimize = context.input("optimize"),
                       .mesh = context.input("mesh"),
                       .refine = context.optional_input("refine"),
                       .decompose = context.optional_input("decompose"),
                       .objects = context.optional_input("objects")},
                      settings);
  const fs::path folder = context.output() / "export";
  make_folders(folder);
  nlohmann::ordered_json written = nlohmann::ordered_json::array();
  std::set<std::string> all;
  const bool by_default = config.formats == export_format_names();
  for (const std::string& name : config.formats) {
    throw_if_interrupted();
    context.progress({.fraction = double(written.size()) / double(config.formats.size()), .text = name, .values = {}});
    const ExportFormat* known = find_export_format(name);
    VITRINE_CHECK(known, "'{}' passed the list of choices", name);
    const ExportFormat& format = *known;
    std::vector<std::string> files;
    if (!format.of_albedo || source.has_albedo()) {
      try {
        files = format.write(source, folder);
      } catch (const Error& e) {
        if (!by_default || e.detail().code != kFormatRange) throw;
        source.add_note("not written: " + e.detail().why);
      }
    } else if (by_default) {
      source.add_note("not written: it needs the decompose stage");
    } else {
      throw without_albedo(format);
    }
    // Formats are exported, kept and replaced individually: no file may belong to two.
    for (const std::string& file : files) VITRINE_CHECK(all.insert(file).second, "two formats write {}", file);
    written.push_back({{"format", format.name},
                       {"summary", format.summary},
                       {"holds", format.holds},
                       {"loses", format.loses},
                       {"files", files}});
    if (const std::vector<std::string> notes = source.take_notes(); !notes.empty()) written.back()["notes"] = notes;
  }
  write_file(folder / "formats.json", written.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  context.metric("files", double(all.size()));
  context.summary(fmt::format("{} files in {} formats{}{}", all.size(), config.formats.size(),
                              settings.scale_note.empty() ? "" : "; ", settings.scale_note));
}

std::string format_table() {
  constexpr size_t kColumns = 100;
  std::string out;
  const auto paragraph = [&](std::string_view label, std::string_view text) {
    std::string line = fmt::format("  {:<7}", label);
    const size_t indent = line.size();
    std::istringstream words{std::string(text)};
    for (std::string word; words >> word;) {
      if (line.size() > indent && line.size() + 1 + word.size() > kColumns) {
        out += line + "\n";
        line.assign(indent, ' ');
      }
      line += (line.size() > indent ? " " : "") + word;
    }
    out += line + "\n";
  };
  for (const ExportFormat& f : export_formats()) {
    out += fmt::format("{}  {}\n", f.name, f.summary);
    paragraph("holds", f.holds);
    paragraph("loses", f.loses);
  }
  return out;
}

Stage export_stage() {
  StageInfo info;
  info.name = "export";
  info.version = 15;
  info.summary = "writes the scene in other programs' formats";
  info.inputs = {{.name = "sfm", .doc = "cameras, sparse points and undistorted photos"},
                 {.name = "optimize", .doc = "the trained surfels"},
                 {.name = "refine", .optional = true, .doc = "better surfels behind glass"},
                 {.name = "mesh", .doc = "the mesh"},
                 {.name = "decompose", .optional = true, .doc = "materials freed of the light of the photos"},
                 {.name = "objects", .optional = true, .doc = "names of the objects"}};
  info.doing = "writing files for other programs";
  info.cost = export_cost;
  return make_stage<ExportConfig>(std::move(info), run_export, {}, problem);
}

StageCost export_cost(const CostTerms& t) {
  const double faces = t.number("mesh.faces"), surfels_k = t.number("optimize.max_gaussians") / 1000;
  return stage_cost(9 + 0.9e-4 * faces + 0.07 * surfels_k, 0.7, 560 + 1e-3 * faces, 25 + 0.66 * surfels_k + 2e-4 * faces);
}

}  // namespace vitrine
