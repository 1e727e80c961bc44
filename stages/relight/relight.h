// relight: pictures of a scene under another light. Started by `vitrine relight`; not part of the graph of `vitrine run`, since
// no stage reads its pictures.
//   reads   sfm, optimize, mesh, decompose (materials, light of the photos); env (HDRI), lights (YAML), path: external files
//   writes  relit/<light>/<view>.{exr,png}, contact_sheet.png, turntable.mp4, transforms.json (the cameras), settings.json
#pragma once

#include <span>
#include <vector>

#include "core/render/picture/picture_views.h"
#include "core/scene/camera/view.h"
#include "stages/stage.h"

namespace vitrine {

struct RelightConfig {
  ViewChoice views = ViewChoice::Heldout;
  int turntable = 0;  // number of frames
  int width = 0, height = 0, samples = 64, seed = 1;
  double rotate = 0, exposure = 0;
  bool auto_exposure = true;
  double frame_rate = 25;
};
void describe(Describer& d, RelightConfig& c);

void run_relight(const RelightConfig& config, StageContext& context);
Stage relight_stage();

// Turntable camera path: orbit about the vertical axis through the point that the photos look at, at their median distance and
// height. If the photos leave a wide gap, the camera oscillates over the covered arc.

// The point closest to the optical axes of all views (least squares).
Vec3d point_looked_at(std::span<const View> views);
// `frames` cameras with the intrinsics of the first view, named frame_0000.png onwards.
std::vector<View> turntable_views(std::span<const View> photos, int frames);

}  // namespace vitrine
