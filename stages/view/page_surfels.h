// Surfels of a scene in the order of the page: opaque surfels of the diffuse layer, transmittance layer, surfels of glass of
// unknown shape, reflection layer. With their additional data: materials of the decompose stage and the light transfer.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/trained_scene.h"
#include "core/render/relight/light_transfer.h"
#include "core/render/relight/relit_scene.h"
#include "stages/view/page_blocks.h"

namespace vitrine {

enum PageSurfelFlag : uint8_t {
  kGuessedSurfel = 1,  // in regions that no photo shows: excluded from reflections in panes (PaneOptions::mirrored)
  kSkySurfel = 2,      // shows the sky of the photos: hidden under another light
  kInsideSurfel = 4,   // of the transmittance layer
};

struct PageSurfels {
  SplatLayer layer;                  // of kind Diffuse, with trained materials
  std::vector<uint32_t> of_diffuse;  // [surfels] index in the diffuse layer, or UINT32_MAX
  std::vector<uint32_t> of_inside;   // [surfels] index in the transmittance layer, or UINT32_MAX
  std::vector<uint8_t> flags;        // [surfels]
  size_t solid = 0;                  // number of surfels that are not glass; they come first
  size_t drawn = 0;                  // number of surfels that are rendered; the reflection layer follows them
  size_t left_out = 0;               // number omitted because of the limit
};

// Each kind is sorted along the Morton curve. At most `most` surfels are rendered: those with the largest opacity times area over
// squared distance to the nearest of `eyes`.
PageSurfels page_surfels(const TrainedScene& scene, std::span<const Vec3d> eyes, size_t most);

// page_places: positions in the page format, as differences between consecutive surfels; sort_along_curve: order that keeps these
// small (Morton curve).
std::vector<uint16_t> page_places(const SplatLayer& layer, std::span<const uint32_t> which);
void sort_along_curve(const SplatLayer& layer, std::vector<uint32_t>& which);

// Flags surfels that show the sky of the photos.
void mark_sky(const DecomposedMaterials& materials, PageSurfels& surfels);

// Materials and light transfer of these surfels.
struct PageLight {
  std::vector<Vec3f> albedo, f0;
  std::vector<float> roughness, specular, transmission;
  std::vector<ReceivedLight> received;
};
PageLight page_light(const RelitScene& scene, const LightTransfer& transfer, const PageSurfels& surfels);

// Writes transfers as `name`_constant (f16 x 3: constant coefficients) and `name` (u8: grey coefficients up to `degree`, relative
// to the constant one).
void add_transfers(std::string_view name, std::span<const Transfer> transfers, int degree, PageBlocks& blocks);

// Writes blocks place, turn, span, opacity, constant, sh, sh_scale, material, flags; with `light` also albedo, lit_material,
// open, side, bounced_constant, bounced (README 7).
void add_surfels(const PageSurfels& surfels, const std::optional<PageLight>& light, PageBlocks& blocks);

}  // namespace vitrine
