// Sampling of surface materials from the diffuse surfels. At points of the mesh (texels, vertices) a short ray crosses the
// surfels from outside to inside, and their attributes are blended with the ray weights w_i = alpha_i T_i. Points without a
// surfel get the values of their mesh neighbours.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/render/trace/tracer.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Exported material of a diffuse surfel, in glTF terms.
struct SurfelMaterial {
  Vec3f color{};        // linear: albedo, or the trained radiance
  Vec3f f0{};           // reflectance at normal incidence
  float roughness = 1;  // perceptual (GGX alpha = roughness^2)
  float transmission = 0;
  Vec3f marks{};  // of brushed metal: their direction times the anisotropy (core/render/picture/decomposed_materials.h)
};

struct SurfaceSample {
  SurfelMaterial material;
  Vec3f normal{};        // blended disk normals, facing out; zero where unknown
  float weight = 0;      // sum of blending weights; 0: no surfel
  float confidence = 0;  // blended confidence of the surfels; 0 without any
};

struct MaterialSource {
  const SplatLayer* surfels = nullptr;
  std::span<const SurfelMaterial> materials;  // [surfels]
  // The first `with_albedo` surfels use `color` of the materials, the others their trained colour along the ray (spherical
  // harmonics).
  size_t with_albedo = 0;
  std::span<const float> confidence = {};  // [surfels] or empty: not measured
};

class SurfaceSampler {
 public:
  // Surfels and materials must outlive the sampler. `behind`: surfels for the content behind glass, which is the mesh's vertices
  // from `first_behind` on; those vertices do not sample the panes' surfels.
  explicit SurfaceSampler(const MaterialSource& surface);
  SurfaceSampler(const MaterialSource& surface, const MaterialSource& behind, uint32_t first_behind);
  bool is_behind(uint32_t vertex) const { return vertex >= first_behind_; }
  // Points on the surface with outward unit normals; rays run from `reach` outside to `reach` inside. `behind`: flags the points
  // behind glass; empty = none.
  std::vector<SurfaceSample> samples(std::span<const Vec3f> points, std::span<const Vec3f> normals, float reach,
                                     std::span<const uint8_t> behind = {}) const;

 private:
  struct Surfels {
    MaterialSource source;
    std::vector<Vec3f> disk_normals;
    std::unique_ptr<Tracer> tracer;

    explicit Surfels(const MaterialSource& from);
    void sample(std::span<const uint32_t> which, std::span<const Vec3f> points, std::span<const Vec3f> normals, float reach,
                std::vector<SurfaceSample>& out) const;
  };
  Surfels surface_;
  std::optional<Surfels> behind_;
  uint32_t first_behind_ = 0xffffffffu;
};

// Samples at the vertices of the mesh. Vertices without a surfel get the mean of their neighbours, ring by ring, or the mesh's
// own colour if no sampled vertex is connected.
std::vector<SurfaceSample> sample_vertices(const SurfaceSampler& sampler, const TriMesh& mesh, float reach);

double mean_edge_length(const TriMesh& mesh);

}  // namespace vitrine
