// The module vitrine._vitrine: the open scene, and the functions that add the classes of the module.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/pybind11.h>

#include "core/foundation/base/file.h"
#include "core/render/picture/picture_views.h"
#include "core/render/picture/view_picture.h"
#include "core/render/relight/relit_scene.h"

namespace vitrine {

// A finished output folder of `vitrine run` or `vitrine compose`: the artifacts that `vitrine render` and `vitrine relight` take.
class FinishedRun {
 public:
  // `edited`: with the edits of `vitrine edit`. Throws Error{Input} if the folder is none, or has no trained scene.
  FinishedRun(const fs::path& project, bool edited);

  const fs::path& project() const { return project_; }
  // The artifact of a stage; nullopt: not computed.
  std::optional<fs::path> artifact(const std::string& stage) const;
  // Throws Error{Input} with `missing` as the message if it was not computed.
  fs::path required(const std::string& stage, const std::string& missing) const;

  TrainedScene trained() const;
  // At the training size, sorted by name.
  std::vector<View> views(ViewChoice which) const;
  std::vector<std::string> heldout() const;  // names
  RelitScene relit() const;

 private:
  fs::path project_, edited_;
};

// An open scene. Its surfels never change their number: arrays over them stay valid while it lives.
struct OpenScene {
  OpenScene(const fs::path& project, bool edited, const PictureDesc& desc);
  FinishedRun run;
  std::vector<View> views;           // of the photos, sorted by name
  std::vector<std::string> heldout;  // names
  ScenePainter painter;
  std::optional<LayeredModel> model;  // of gradients
  Frame frame;                        // likewise
  bool differentiating = false;       // a function of the picture runs
  std::recursive_mutex busy;          // painter, model, frame
};
using ScenePointer = std::shared_ptr<OpenScene>;

// One set of surfels of an open scene.
struct SurfelSet {
  ScenePointer scene;
  SplatLayer* layer;
};

void bind_errors(pybind11::module_& m);
void bind_cameras(pybind11::module_& m);
void bind_surfels(pybind11::module_& m);
void bind_objects(pybind11::module_& m);  // and the mesh
void bind_relighting(pybind11::module_& m);
void bind_scene(pybind11::module_& m);

pybind11::list objects_of(const FinishedRun& run);
pybind11::object mesh_of(const FinishedRun& run);
// Gradients of one set by attribute, [surfels, width]; takes them.
pybind11::dict gradients_of(SplatLayer gradients);
pybind11::object relighting_of(const FinishedRun& run, const pybind11::object& environment, double rotate,
                               const std::optional<std::string>& lights, uint64_t seed);

}  // namespace vitrine
