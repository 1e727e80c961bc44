// compose: several finished scenes, or objects of them, in one frame under similarities. Started by `vitrine compose`; not part
// of the graph of `vitrine run`.
//   reads   scene: a YAML file (README.md) that names projects; their current artifacts (composition_files: these enter the key)
//   writes  gaussians/, optimize/, mesh/, decompose/, objects/ like the artifacts of those stages; compose/report.json: place,
//   size
//           and object ids of each part. Cameras, photos and masks of the composition are those of the first part.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/render/edit/edit_scene.h"
#include "core/render/edit/selection.h"
#include "core/scene/camera/view.h"
#include "stages/stage.h"

namespace vitrine {

struct ComposeConfig {};
void describe(Describer& d, ComposeConfig& c);

void run_compose(const ComposeConfig& config, StageContext& context);
Stage compose_stage();

struct CompositionPart {
  std::string name, where;      // where: file:line:col
  std::string project, wanted;  // as written in the file; description of the selector
  std::filesystem::path sfm;
  EditFolders folders;
  std::optional<std::filesystem::path> masks = {}, objects = {};
  std::vector<View> views;
  std::optional<Selector> select = {};  // nullopt: the whole scene
  Similarity place = {};                // its frame to that of the first part, which stays where it is
};

// At least one part; the first is the host. Projects are relative to the file. Throws Error{Usage} with every mistake at its
// line, Error{Input} if a project has no finished scene, or no common unit with the host.
std::vector<CompositionPart> read_composition(const std::filesystem::path& file);
// The manifests of all artifacts that these projects have, in order. Mistakes in the file are left to read_composition().
std::vector<std::filesystem::path> composition_files(const std::filesystem::path& file);

}  // namespace vitrine
