// Surfels of a scene in the order of the page: opaque surfels of the diffuse layer, transmittance layer, surfels of glass of
// unknown shape, reflection layer. With their additional data: materials of the decompose stage and the light transfer.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/base/json.h"
#include "core/render/edit/edit_scene.h"
#include "core/render/picture/confidence.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/trained_scene.h"
#include "core/render/relight/light_transfer.h"
#include "core/render/relight/relit_scene.h"
#include "core/scene/camera/view.h"
#include "core/scene/objects/object_labels.h"
#include "core/scene/objects/object_set.h"
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

// Writes blocks scattering (surfels that scatter light below their surface), lender (24 surfels around each, itself among them)
// and lent_share (their shares per channel, bytes with sum 255): core/render/relight/subsurface.h. Nothing if there are none.
void add_subsurface(const RelitScene& scene, const PageSurfels& surfels, PageBlocks& blocks);

// Writes transfers as `name`_constant (f16 x 3: constant coefficients) and `name` (u8: grey coefficients up to `degree`, relative
// to the constant one).
void add_transfers(std::string_view name, std::span<const Transfer> transfers, int degree, PageBlocks& blocks);

// Writes blocks place, turn, span, opacity, constant, sh, sh_scale, material, flags; with `light` also albedo, lit_material,
// open, side, bounced_constant, bounced (README 7).
void add_surfels(const PageSurfels& surfels, const std::optional<PageLight>& light, PageBlocks& blocks);

// Data for previewing edits in the page as `vitrine edit` would apply them (core/render/edit): mask classes and mesh component of
// every surfel, positions of surfels that the page does not render, and the surfels of each known shape.

// Writes the block part_object: id of the object of each rendered surfel, 0: none. Without objects there is no block. Returns the
// list [{"id", "name", "role", "trust"}].
nlohmann::ordered_json add_objects(const ObjectSet& set, const SplatScene& scene, const PageSurfels& surfels, PageBlocks& blocks);

// Writes blocks. part_class and part_component of the rendered surfels (class: one bit each, in the order of kMaskClasses;
// component 0: none, or beyond 255). absent_place, absent_class, absent_component, absent_flags and, if there are objects,
// absent_object (like part_object) of the diffuse surfels that are not rendered. shape_surfel: surfels of each
// entry of `shapes` (page_blocks.h), as indices into the rendered surfels followed by the absent ones; the entry gets their count
// as "surfels". Returns {"there": true, "classes": names, "no_classes": reason if there are none, "components": count}.
nlohmann::ordered_json add_edits(const EditScene& scene, std::span<const View> views, const ClassPixels& pixels,
                                 const PageSurfels& surfels, nlohmann::ordered_json& shapes, PageBlocks& blocks);

// For a page without edits; `why` is the reason.
nlohmann::ordered_json no_edits(const std::string& why);

// Coverage of the rendered surfels by photos.
std::vector<PhotoCoverage> page_coverage(const PageSurfels& surfels, std::span<const View> photos, float near_z);

// 8 min(photos, 12) + min(floor(angle / 10 degrees), 6).
uint8_t coverage_byte(const PhotoCoverage& coverage);

// Writes the block seen: one byte per rendered surfel.
void add_coverage(std::span<const PhotoCoverage> coverage, PageBlocks& blocks);

// Light probes for reflections of specular surfaces under another light: seen from their centre, the radiance of the mesh in all
// directions (core/render/relight/light_transfer.h) and its distance. The page marches along a reflected ray until its distance
// from the centre matches the probe (parallax correction). (Under the light of the photos it traces rays through the reflection
// layer.)
//
// Directions: octahedral map (core/scene/light/environment.h).
//
// Directions by the octahedral map (core/scene/light/environment.h).

inline constexpr int kProbeSide = 128;
inline constexpr size_t kMostProbes = 4;

struct LightProbe {
  Vec3d centre{};
  // [side, side] rows first
  std::vector<Transfer> sent;  // radiance for unit coefficients
  std::vector<float> open;     // share of light from outside
  std::vector<float> depth;    // distance of the surface; 0: sky
};

// At this distance a ray is clear of the mesh and the surfels of the surface it leaves.
float clear_of_surface(const RelitScene& scene, const LightTransfer& transfer);

// One probe per known opaque shape, at its centre; otherwise one at the centre of the specular surfels; otherwise one at
// `middle`. Never empty.
std::vector<LightProbe> probes(const RelitScene& scene, const LightTransfer& transfer, const Vec3d& middle);

// Writes blocks probe, probe_constant (add_transfers) and probe_way (open, depth); probes are concatenated.
void add_probes(std::span<const LightProbe> probes, PageBlocks& blocks);

}  // namespace vitrine
