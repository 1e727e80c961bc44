// Subsurface scattering of wax, marble, alabaster: light leaves a surface around the place where it entered. A filter of the
// irradiance of the mesh vertices with the normalised diffusion profile of Christensen and Burley 2015 ("Approximate Reflectance
// Profiles for Efficient Subsurface Scattering", eq. 2, 3 and 6), r the straight distance between the two places:
//   R(r) = (exp(-r/d) + exp(-r/(3 d))) / (8 pi d r),    d = l / s,    s = 1.9 - A + 3.5 (A - 0.8)^2
//   E'(x) = sum_k R(|x - x_k|) a_k E(x_k) / sum_k R(|x - x_k|) a_k
// l: mean free path, A: albedo, a_k: area of vertex k. Light that enters the back of a thin part leaves its front. Rows sum to 1,
// so that constant light stays constant. Far vertices are summed in groups (Jensen and Buhler 2002).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

// d of a surface with mean free path `length` and this albedo.
float diffusion_length(float length, float albedo);
// R(r), per area.
float diffusion_profile(float r, float d);
// Share of the light that leaves within distance r of where it entered: the integral of 2 pi r R(r).
float leaves_within(float r, float d);

class SubsurfaceFilter {
 public:
  // No vertex scatters.
  SubsurfaceFilter() = default;
  // `length`: mean free path per vertex and channel, scene units; 0: opaque. `albedo`: per vertex. `detail`: distance below which
  // the values of vertices hold no detail (the edge length of the mesh).
  SubsurfaceFilter(const TriMesh& mesh, std::span<const Vec3f> length, std::span<const Vec3f> albedo, float detail);
  bool empty() const { return vertices_.empty(); }

  // Filters [v] values in place; vertices that do not scatter keep theirs and lend nothing.
  void apply(std::vector<Vec3f>& irradiance) const;
  // [v] share of the light that leaves farther than `detail` from where it entered. Empty if nothing scatters.
  const std::vector<Vec3f>& share() const { return share_; }

 private:
  struct Node {
    Vec3f centre{};    // weighted by area
    float radius = 0;  // of the vertices around the centre
    float area = 0;
    uint32_t first = 0, last = 0;  // in vertices_
    uint32_t left = 0, right = 0;  // 0: a leaf
  };
  uint32_t build(const TriMesh& mesh, uint32_t first, uint32_t last);
  Vec3f filtered(uint32_t at, std::span<const Vec3f> power, std::span<const Vec3f> values) const;

  std::vector<uint32_t> vertices_;  // that scatter, in the order of the tree
  std::vector<Vec3f> places_;       // of vertices_
  std::vector<float> area_;         // of vertices_
  std::vector<Vec3f> d_;            // of vertices_
  std::vector<Node> nodes_;
  std::vector<Vec3f> share_;  // [v]
};

}  // namespace vitrine
