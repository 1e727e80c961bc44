// Irradiance of the transmittance-layer surfels, which are seen only through glass. Points near these surfels are sampled from
// the pictures of the scene without glass (core/render/model/opened_scene.h). They receive light like other surfaces, through the
// panes of the mesh; the content behind glass (mesh/behind_glass.ply) casts the shadows.
#pragma once

#include <functional>
#include <vector>

#include "core/render/picture/trained_scene.h"
#include "stages/decompose/spread.h"
#include "stages/decompose/transport.h"

namespace vitrine {

struct BehindGlassDesc {
  const TrainedScene& scene;
  const std::vector<View>& views;
  const TransportScene& first;      // surfaces and surrounding shell, without the content behind glass
  const TriMesh& content;           // content behind glass; may be empty; its colours are assigned here
  const std::vector<Vec3f>& light;  // [cells] the solved light
  LitPointsDesc points;
  TransportDesc rays;
  SpreadDesc spread;
};

// [surfels of the transmittance layer]; empty if no photo shows any of them.
std::vector<Vec3f> irradiance_behind_glass(const BehindGlassDesc& desc, const std::function<void(double)>& progress);

}  // namespace vitrine
