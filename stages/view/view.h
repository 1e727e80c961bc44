// view: the scene as one HTML file that needs no server and no network (README). Started by `vitrine view` and at the end of
// `vitrine run`; like render, it is not part of the graph.
//   reads   sfm (cameras, photos), optimize; refine, mesh, decompose if they exist
//   writes  view.html
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct ViewConfig {
  int surfels = 250000;
  int photo_side = 480;
  int rays = 64;
  int mesh_faces = 20000;
};
void describe(Describer& d, ViewConfig& c);

// `page`: HTML without a scene (stages/page_text.h).
void write_view(const std::string& page, const ViewConfig& config, StageContext& context);
void run_view(const ViewConfig& config, StageContext& context);
Stage view_stage();

}  // namespace vitrine
