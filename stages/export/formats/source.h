// Data for export: artifacts of the earlier stages, read on first use and cached, and the output frame.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/render/model/frame.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/objects/object_set.h"
#include "core/scene/surfels/layers.h"
#include "stages/export/bake/pbr_mesh.h"

namespace vitrine {

// Coordinate frame of the output files: the scene frame (right-handed, +z up), rotated or mirrored to the axes of another program
// and scaled to a unit of length.
//   rhzu  right-handed, z up: the scene's own     rhyu  right-handed, y up (x, z, -y): glTF, three.js
//   lhzu  left-handed, z up (x, -y, z): Unreal    lhyu  left-handed, y up (x, z, y): Unity

enum class ExportAxes { Rhzu, Rhyu, Lhzu, Lhyu };
inline constexpr std::array<std::string_view, 4> kExportAxesWords{"rhzu", "rhyu", "lhzu", "lhyu"};

struct ExportFrame {
  Mat3d axes = Mat3d::identity();  // orthogonal; determinant -1 if the handedness changes
  double scale = 1;                // file units per scene unit

  static ExportFrame of(ExportAxes axes, double scale);

  bool identity() const { return axes == Mat3d::identity() && scale == 1; }
  bool mirrored() const { return determinant(axes) < 0; }
  bool y_up() const { return axes(1, 2) != 0; }
  Vec3f point(const Vec3f& p) const { return float(scale) * direction(p); }
  Vec3f direction(const Vec3f& d) const { return cast<float>(axes) * d; }
};

// The same surface in the frame: points, normals, and corner order if the frame is mirrored.
TriMesh in_frame(const TriMesh& mesh, const ExportFrame& frame);
// Means, disks, sizes and spherical harmonics (bands do not mix: the matrix of each band is computed by projection).
SplatLayer in_frame(const SplatLayer& layer, const ExportFrame& frame);

struct ExportInputs {
  std::filesystem::path sfm, optimize, mesh;
  std::optional<std::filesystem::path> refine, decompose, objects;
};

struct ExportSettings {
  ExportAxes axes = ExportAxes::Rhzu;
  double scale = 0;             // file units per scene unit; 0: metres where their size is known, else 1
  std::string scale_note = {};  // where the scale comes from, for the notes of formats that have lengths
  int texture_size = 0;         // 0: by the mesh
};

// Cameras of the undistorted photos, from sparse/0 of an sfm artifact.
std::vector<View> photo_cameras(const std::filesystem::path& sfm);

class ExportSource {
 public:
  ExportSource(ExportInputs inputs, ExportSettings settings) : inputs_(std::move(inputs)), settings_(std::move(settings)) {}
  const std::filesystem::path& sfm() const { return inputs_.sfm; }
  const std::filesystem::path& optimize() const { return inputs_.optimize; }
  const std::optional<std::filesystem::path>& decompose() const { return inputs_.decompose; }

  ExportFrame frame() { return frame(settings_.axes); }                 // of the settings
  ExportFrame frame(ExportAxes axes);                                   // other axes, for formats that have only one
  bool metric();                                                        // lengths are metres
  const std::optional<GeoOrigin>& place() { return scene_info().geo; }  // of the origin, by GPS
  // Of the table of objects. 0, and what has none: "scene"; an id that the table does not know: "object-7".
  std::string object_name(uint16_t id);
  // `lines`, and one line per object if surfels have ids: "object 3: vase, mirror".
  std::vector<std::string> header_lines(std::vector<std::string> lines);
  const TrainedScene& scene();
  const SplatLayer& diffuse() { return scene().surfels.diffuse; }
  // With vertex normals; checked: finite, not empty. Content behind glass comes last, from vertex first_behind_glass() on;
  // content that straight rays painted into solid glass is removed. Solid glass has the normals used for refraction.
  const TriMesh& mesh();
  uint32_t first_behind_glass() { return mesh(), first_behind_glass_; }
  // Materials of the diffuse surfels; has_albedo(): their colour is the albedo of the decompose stage, else the captured
  // radiance.
  const std::vector<SurfelMaterial>& materials();
  bool has_albedo() const { return inputs_.decompose.has_value(); }
  // Output of the decompose stage, checked: one per diffuse surfel. Requires has_albedo().
  const DecomposedMaterials& decomposed();
  // Of the diffuse surfels (core/render/picture/confidence.h). Empty if the training photos or their list are missing.
  std::span<const float> confidence();
  // At the vertices of mesh().
  const std::vector<SurfaceSample>& vertex_samples();
  const PbrMesh& pbr_mesh();
  // The diffuse surfels with the colours of the composed pictures, as display values.
  const SplatLayer& preview();

  // Adds a note about the data read since the last call, for export/formats.json.
  void add_note(std::string note) { notes_.push_back(std::move(note)); }
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

 private:
  const SceneInfo& scene_info();
  const ObjectSet& objects();
  const SurfaceSampler& sampler();
  float reach();

  ExportInputs inputs_;
  ExportSettings settings_;
  std::optional<SceneInfo> info_;
  std::optional<TrainedScene> scene_;
  std::optional<ObjectSet> objects_;
  std::optional<TriMesh> mesh_;
  std::optional<SolidGlass> solid_;  // faces and vertices of mesh_
  uint32_t first_behind_glass_ = 0;
  OpenedScene content_;
  std::vector<SurfelMaterial> content_materials_;
  std::optional<DecomposedMaterials> decomposed_;
  std::optional<std::vector<SurfelMaterial>> materials_;
  std::optional<std::vector<float>> confidence_;
  std::optional<SurfaceSampler> sampler_;  // references scene_ and materials_
  std::optional<std::vector<SurfaceSample>> vertex_samples_;
  std::optional<PbrMesh> pbr_mesh_;
  std::optional<SplatLayer> preview_;
  std::vector<std::string> notes_;
};

// One sentence on the origin of the colours in mesh formats.
std::string color_note(const ExportSource& source);

// Interface of an export format: name, contents, losses and writer. The list is formats/registry.cpp, one line per format; each
// format has its own file in this folder. The strings are the documentation (README, export/formats.json, `vitrine export
// --list`).

struct ExportFormat {
  std::string_view name;     // name in --set formats=[...]
  std::string_view summary;  // one line
  std::string_view holds;    // contents of the files
  std::string_view loses;    // scene data missing in the files
  bool of_albedo = false;    // requires the decompose stage: without it skipped if all formats are written, else an error
  // Writes to `folder` and returns the written paths, relative to it.
  std::vector<std::string> (*write)(ExportSource& source, const std::filesystem::path& folder);
};

// Code of the Error of a format that cannot hold the scene. With the default list such a format is skipped, with a note.
inline constexpr const char* kFormatRange = "FORMAT_RANGE";

std::span<const ExportFormat> export_formats();
std::vector<std::string> export_format_names();
const ExportFormat* find_export_format(std::string_view name);

}  // namespace vitrine
