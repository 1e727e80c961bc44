// Where known solids end in a picture: solids of revolution and what stands out of them, all together. Their outline is known to
// a fraction of a pixel, and with it how much of each pixel they cover; how the coverage changes with the solids tells training
// where photos see the outline.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera/view.h"
#include "core/model/shape_mesh.h"
#include "core/shape/surface_of_revolution.h"

namespace vitrine {

// Pixels that lie this near to the outline belong to its band: surfels of the solid, which are as large as that, blur it so far.
inline constexpr int kOutlineBand = 4;

struct OutlinePixel {
  uint32_t pixel = 0, shape = 0;  // of the solids; their number: of the mesh
  float covered = 0;              // by the solid, 0 to 1
  float z = 0;                    // z-depth of the solid: where the pixel shows it; else of the nearest part of the outline
  float away = 0;                 // pixels to the nearest pixel that the outline crosses
  Vec3f normal{};                 // of the solid where the pixel shows it: of the middle of what is covered
  bool crossed = false;           // by the outline; what follows is of those alone
  uint32_t line = 0;              // of the profile that the outline is on, or face of the mesh
  float along = 0;                // between the corners of that line
  float u = 0, v = 0;             // in the face
  Vec3d place{};                  // in the world
  Vec3d grows{};                  // d covered / d place: the solid's surface moves by dx there, covered by dot(grows, dx)
};

// Pixels ascending. `beside`: what stands out of the shapes, or nullptr. What reaches behind the camera has no outline.
std::vector<OutlinePixel> outline_pixels(const std::vector<SurfaceOfRevolution>& shapes, const ShapeMesh* beside,
                                         const View& view);

// From dL/d covered of a crossed pixel to the parameters of the solid, added.
void outline_vjp(const OutlinePixel& at, const SurfaceOfRevolution& shape, double grad_covered, std::vector<double>& grad);
// The same of one on the mesh, to displacements of its vertices.
void outline_vjp(const OutlinePixel& at, const ShapeMesh& mesh, double grad_covered, std::vector<double>& grad);

}  // namespace vitrine
