// The light on what is seen through glass alone, the surfels of the transmittance layer. Photos show it in the picture of
// everything but the glass (core/render/model/opened_scene.h): points of that picture near surfels of the layer receive light as those
// of first surfaces do, through the panes of the mesh, and what stands behind glass (mesh/behind_glass.ply) throws its shadows.
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
  const TransportScene& first;      // surfaces and shell, as light meets them without what stands behind glass
  const TriMesh& content;           // that; may be empty. Its colours are found here
  const std::vector<Vec3f>& light;  // [cells] as solved
  LitPointsDesc points;
  TransportDesc rays;
  SpreadDesc spread;
};

// [surfels of the transmittance layer]; empty when no photo shows any of them.
std::vector<Vec3f> irradiance_behind_glass(const BehindGlassDesc& desc, const std::function<void(double)>& progress);

}  // namespace vitrine
