// render: pictures of a trained scene and their layers, from the cameras of the photos or along a path. Started by `vitrine
// render`; not part of the graph of `vitrine run`, since no stage reads its pictures.
//   reads   sfm/{sparse,gains}, gaussians/*.ply, optimize/views.json, optional path (transforms.json)
//   writes  render/<view>.png, render/layers/<layer>/<view>.exr, render/transforms.json (all cameras)
#pragma once

#include <string>

#include "core/render/picture/picture_views.h"
#include "core/render/raster/renderer.h"
#include "stages/stage.h"

namespace vitrine {

enum class RenderCamera { Perspective, Equirect };
inline constexpr std::array<std::string_view, 2> kRenderCameraWords{"perspective", "equirect"};

struct RenderConfig {
  ViewChoice views = ViewChoice::Heldout;
  RenderCamera camera = RenderCamera::Perspective;
  bool layers = false;
  bool without_medium = false;
  int width = 0, height = 0, samples = 0;
  std::string frames = {};  // "10-19": a part of the pictures
  Backend backend = Backend::Cpu;
};
void describe(Describer& d, RenderConfig& c);

void run_render(const RenderConfig& config, StageContext& context);
Stage render_stage();

}  // namespace vitrine
