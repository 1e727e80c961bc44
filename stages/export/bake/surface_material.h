// What the surface looks like and is made of, read off the diffuse surfels: at points of the mesh (texels, vertices) a short ray
// crosses the surfels from outside to inside, and what they carry is blended with the weights of the ray, w_i = alpha_i T_i.
// Where no surfel is met, the answer is spread from the neighbours on the mesh.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"
#include "core/render/trace/tracer.h"

namespace vitrine {

// Materials of every diffuse surfel in glTF's sense: what is exported.
struct SurfelMaterial {
  Vec3f color{};        // linear: albedo, or the radiance that the surfel was trained to show
  Vec3f f0{};           // reflectance at normal incidence
  float roughness = 1;  // perceptual (GGX alpha = roughness^2)
  float transmission = 0;
};

struct SurfaceSample {
  SurfelMaterial material;
  Vec3f normal{};    // blended disk normals, facing out; zero where unknown
  float weight = 0;  // summed blending weight; 0: nothing was met
};

struct MaterialSource {
  const SplatLayer* surfels = nullptr;
  std::span<const SurfelMaterial> materials;  // [surfels]
  // Of the first so many surfels `color` of the materials counts. Of others the trained colour, seen along the ray, counts
  // (spherical harmonics).
  size_t with_albedo = 0;
};

class SurfaceSampler {
 public:
  // Surfels and materials stay the caller's and must outlive it. `behind`: of what stands behind glass, the mesh's vertices from
  // `first_behind` on; they meet none of the panes' surfels.
  explicit SurfaceSampler(const MaterialSource& surface);
  SurfaceSampler(const MaterialSource& surface, const MaterialSource& behind, uint32_t first_behind);
  bool is_behind(uint32_t vertex) const { return vertex >= first_behind_; }
  // Points on the surface with outward unit normals; rays run from `reach` outside to `reach` inside. `behind`: which points
  // stand behind glass; empty = none.
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

// Sampled at the vertices of the mesh; vertices that met nothing take the mean of their neighbours, ring by ring; vertices out
// of reach of any take the mesh's own colour.
std::vector<SurfaceSample> sample_vertices(const SurfaceSampler& sampler, const TriMesh& mesh, float reach);

double mean_edge_length(const TriMesh& mesh);

}  // namespace vitrine
