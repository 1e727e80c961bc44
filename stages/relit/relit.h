// relit: pictures of a scene under another light. Started by `vitrine relight`; it stands beside the graph of `vitrine run`,
// because nothing follows from its pictures.
//   reads   sfm, optimize, mesh, relight (materials, light of the photos); env (HDRI), lights (YAML), path: outside files
//   writes  relit/<light>/<view>.{exr,png}, contact_sheet.png, turntable.mp4, transforms.json (the cameras), settings.json
// version 1: first. 2: environment and lamps together have a folder of their own. 3: solid glass bends rays. 4: lit walls.
// 5: a rough mesh throws no shadows. 6: shadow rays meet faces in any order. 7: panes of a case mirror. 8: environment maps of
// Radiance are divided by their EXPOSURE and COLORCORR, and multilayer EXR maps are read; a camera path keeps the order of its
// file.
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct RelitConfig {
  std::string views = "heldout";
  int turntable = 0;  // frames
  int width = 0, height = 0, samples = 64, seed = 1;
  double rotate = 0, exposure = 0;
  bool auto_exposure = true;
  double frame_rate = 25;
};
void describe(Describer& d, RelitConfig& c);

void run_relit(const RelitConfig& config, StageContext& context);
Stage relit_stage();

}  // namespace vitrine
