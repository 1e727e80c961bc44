// relight: pictures of a scene under another light. Started by `vitrine relight`; not part of the graph of `vitrine run`, since
// no stage reads its pictures.
//   reads   sfm, optimize, mesh, decompose (materials, light of the photos); env (HDRI), lights (YAML), path: external files
//           compose (the parts of a composition), for pictures over a photo
//   writes  relit/<light>/<view>.{exr,png}, contact_sheet.png, turntable.mp4, transforms.json (the cameras), settings.json
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/foundation/base/file.h"
#include "core/render/edit/edit_scene.h"
#include "core/render/picture/picture_views.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/light/lighting.h"
#include "stages/stage.h"

namespace vitrine {

struct RelightConfig {
  ViewChoice views = ViewChoice::Heldout;
  int turntable = 0;  // number of frames
  int width = 0, height = 0, samples = 64, seed = 1;
  double rotate = 0, exposure = 0;
  bool auto_exposure = true;
  double frame_rate = 25;
  std::string frames = {};  // "10-19": a part of the pictures
  std::string over = {};  // name of a photo of the composition's host; empty: pictures of the whole scene
};
void describe(Describer& d, RelightConfig& c);

void run_relight(const RelightConfig& config, StageContext& context);
Stage relight_stage();

// Guest of a composition over a photo of its host (README.md): what the photo would show if the guest had stood there.

struct GuestPicture {
  ImageF over;       // [h, w, 4] radiance of the guest times its coverage, and 1 - (1 - coverage) times the shadow's luminance
  ImageF shadow;     // [h, w, 3] radiance of the host's surfaces with the guest, divided by that without it; 1: none
  ImageF composite;  // [h, w, 3] the photo with both
};
struct GuestDesc {
  View view;     // at the size of the picture
  ImageF photo;  // [h, w, 3] linear, of the same size
  int samples = 64;
  uint64_t seed = 1;
  std::optional<double> stops = {};  // brightens the guest; nullopt: the host's surfaces get the mean of the photo
};
// `scene`: all of its parts, whatever its flags. `guests`: ids of the objects that are not of the host.
GuestPicture guest_over_photo(const EditScene& scene, std::span<const uint16_t> guests, const Lighting& lighting,
                              const GuestDesc& desc);
// Object ids of the guests, from compose/report.json of the composition. Throws Error{Input} if there are none.
std::vector<uint16_t> guest_ids(const fs::path& compose);

// Turntable camera path: orbit about the vertical axis through the point that the photos look at, at their median distance and
// height. If the photos leave a wide gap, the camera oscillates over the covered arc.

// The point closest to the optical axes of all views (least squares).
Vec3d point_looked_at(std::span<const View> views);
// `frames` cameras with the intrinsics of the first view, named frame_0000.png onwards.
std::vector<View> turntable_views(std::span<const View> photos, int frames);

}  // namespace vitrine
