// render: pictures of a trained scene, from the cameras of its photos or along a path, and the layers they are made of. Started
// by `vitrine render`; it stands beside the graph of `vitrine run`, because nothing follows from its pictures.
//   reads   sfm/{sparse,gains}, gaussians/*.ply, optimize/views.json, optional path (transforms.json)
//   writes  render/<view>.png, render/layers/<layer>/<view>.exr, render/transforms.json (the cameras)
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
