// The union of several scenes in one frame. The first part is the host: its object ids, image formation and light stay.
//
// Surfels, meshes, walls, materials and known shapes of all parts follow each other. Object ids of the other parts are
// renumbered; what has no object there gets one of the part's name, so that edits can select the part and relighting knows
// the guests. A guess about unobserved regions (PaneOptions::mirrored) stays behind all surfels that were observed. The
// opaque twin of a part without one is its diffuse layer.
#pragma once

#include <string>
#include <vector>

#include "core/render/edit/edit_scene.h"
#include "core/scene/objects/object_set.h"

namespace vitrine {

struct ScenePart {
  std::string name;   // for messages, and of the object of its unlabelled surfels
  std::string where;  // file:line:col
  EditScene scene;    // all of it is used, whatever its flags (kept())
  ObjectSet objects;  // of its project, in the same frame
};

struct JoinedScene {
  EditScene scene;  // without materials if a part has none
  ObjectSet objects;
  std::vector<std::vector<uint16_t>> ids;  // [part] its objects in `objects`; the host's: those of its table
};

// At least one part. Throws Error{Input} if two parts were trained with another image formation.
JoinedScene joined(std::vector<ScenePart> parts);

// True if the surfels reflect or transmit: the scene needs its image formation options.
bool is_layered(const EditScene& scene);

}  // namespace vitrine
