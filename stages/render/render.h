// render: pictures of a trained scene, from the cameras of its photos or along a path, and the layers they are made of. Started
// by `vitrine render`; it stands beside the graph of `vitrine run`, because nothing follows from its pictures.
//   reads   sfm/{sparse,gains}, gaussians/*.ply, optimize/views.json, optional path (transforms.json)
//   writes  render/<view>.png, render/layers/<layer>/<view>.exr, render/transforms.json (the cameras)
// version 1: first. 2: total reflection in solid glass. 3: rims mirror less. 4: surfels that agree mirror farther. 5: panes of a
//   case mirror. 6: a camera path keeps the order of its file.
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct RenderConfig {
  std::string views = "heldout";
  bool layers = false;
  int width = 0, height = 0, samples = 0;
  std::string backend = "cpu";
};
void describe(Describer& d, RenderConfig& c);

void run_render(const RenderConfig& config, StageContext& context);
Stage render_stage();

}  // namespace vitrine
