// Data for export: artifacts of the earlier stages, read on first use and cached, and the output frame.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/render/model/frame.h"
#include "core/scene/objects/object_set.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/trained_scene.h"
#include "stages/export/bake/pbr_mesh.h"
#include "stages/export/formats/frame.h"

namespace vitrine {

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
  const std::optional<std::filesystem::path>& decompose() const { return inputs_.decompose; }

  ExportFrame frame() { return frame(settings_.axes); }  // of the settings
  ExportFrame frame(ExportAxes axes);                    // other axes, for formats that have only one
  bool metric();                                         // lengths are metres
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
  std::optional<SurfaceSampler> sampler_;  // references scene_ and materials_
  std::optional<std::vector<SurfaceSample>> vertex_samples_;
  std::optional<PbrMesh> pbr_mesh_;
  std::optional<SplatLayer> preview_;
  std::vector<std::string> notes_;
};

// One sentence on the origin of the colours in mesh formats.
std::string color_note(const ExportSource& source);

}  // namespace vitrine
