// The surfels of a scene as its page draws them: everything but the glass, first the opaque surfels of the diffuse layer, then
// the transmittance layer; behind them surfels of glass whose shape is not known. What they need beside their own values:
// materials of the decompose stage and the transfer of light.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/picture/decomposed_materials.h"
#include "core/picture/trained_scene.h"
#include "core/relight/light_transfer.h"
#include "core/relight/relit_scene.h"
#include "stages/view/page_blocks.h"

namespace vitrine {

enum PageSurfelFlag : uint8_t {
  kGuessedSurfel = 1,  // about what no photo shows: panes do not mirror it (PaneOptions::mirrored)
  kSkySurfel = 2,      // shows the light of the photos: absent under another
  kInsideSurfel = 4,   // of the transmittance layer
};

struct PageSurfels {
  SplatLayer layer;                  // of kind Diffuse, with trained materials
  std::vector<uint32_t> of_diffuse;  // [surfels] index in the diffuse layer, or UINT32_MAX
  std::vector<uint32_t> of_inside;   // [surfels] likewise in the transmittance layer
  std::vector<uint8_t> flags;        // [surfels]
  size_t solid = 0;                  // so many are no glass; glass stands behind them
  size_t drawn = 0;                  // so many are not of the reflection layer, which stands behind
  size_t left_out = 0;               // of the scene's, for there were too many
};

// In the order of Morton's curve, each kind. At most `most` surfels are drawn: those stay that cover most of the pictures, by
// opacity times area over the squared distance to the nearest of `eyes`.
PageSurfels page_surfels(const TrainedScene& scene, std::span<const Vec3d> eyes, size_t most);

// Places of some surfels as the page has them, each as its difference to the one before; and the order in which those are small.
std::vector<uint16_t> page_places(const SplatLayer& layer, std::span<const uint32_t> which);
void sort_along_curve(const SplatLayer& layer, std::vector<uint32_t>& which);

// Flags those that show the light of the photos.
void mark_sky(const DecomposedMaterials& materials, PageSurfels& surfels);

// Materials and transfer of these surfels under other lights.
struct PageLight {
  std::vector<Vec3f> albedo, f0;
  std::vector<float> roughness, specular, transmission;
  std::vector<ReceivedLight> received;
};
PageLight page_light(const RelitScene& scene, const LightTransfer& transfer, const PageSurfels& surfels);

// Transfers as the page has them: `name`_constant f16 of three, their constant coefficients; `name` u8, the others up to that
// degree in units of it, without colour.
void add_transfers(std::string_view name, std::span<const Transfer> transfers, int degree, PageBlocks& blocks);

// Blocks place, turn, span, opacity, constant, sh, sh_scale, material, flags; with a light albedo, lit_material, open, side,
// bounced_constant, bounced (README, "What the file holds").
void add_surfels(const PageSurfels& surfels, const std::optional<PageLight>& light, PageBlocks& blocks);

}  // namespace vitrine
