// Inpainting of regions that no photo sees, outside all images or occluded: novel views would see holes there. The large planes
// of the scene (walls, floor, table) are extended: cells that no photo sees, or sees through, get colours from Laplace's
// equation, up to a limited distance from the last seen cell. The sky is extended in the same way. Surfels that would be visible
// in a training photo are removed. This is a guess of colours only; no geometry is added. Also moves surfels that photos see only
// through glass from the transmittance to the diffuse layer.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/learn/trainer/capture.h"
#include "core/observe/stereo/scene_planes.h"
#include "core/render/model/kernels/medium.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

// Inpainting of surface cells that no photo sees. Cells seen by photos give the boundary colours of Laplace's equation; cells
// that photos see through stay empty. The solution extends a limited distance from the last seen cell.

inline constexpr size_t kUnseenLevel = 1;  // level of the photo pyramids

// A training photo and its z-depth [h,w], rendered from the trained surfels; 0 = no surface.
struct SeenPhoto {
  const PhotoLevel* photo;
  std::vector<float> zdepth;
  const MediumCoefficients<double>* medium = nullptr;  // in front of the camera
};

// Visibility of a place in a photo: `place_z` is the depth of the place, `zdepth` the rendered depth there, 0 = no surface.
enum class Sight : uint8_t { Unseen, Seen, Through };

struct CellSurface {
  int columns = 0, rows = 0;
  bool round = false;  // closed: the last column is adjacent to the first
  std::function<Vec3d(double column, double row)> place;
  std::function<Sight(double place_z, double zdepth)> sight;
};

class UnobservedCells {
 public:
  // `reach`: largest distance from a seen cell, in cells.
  UnobservedCells(const CellSurface& surface, std::span<const SeenPhoto> photos, double reach);

  // Visits the unseen cells within reach, merged into the largest squares: visit(centre, side in cells, linear colour).
  void for_guessed(const std::function<void(const Vec3d&, int, const Vec3d&)>& visit) const;

 private:
  struct Cell {
    Sight sight = Sight::Unseen;
    bool reached = false;  // seen, or within reach of a seen cell
    Vec3d linear{};
  };
  Cell looked_at(std::span<const SeenPhoto> photos, const Vec3d& place) const;
  template <class Visit>
  void for_neighbours(size_t cell, const Visit& visit) const;
  void close_gaps(double reach);

  CellSurface surface_;
  std::vector<Cell> cells_;
};

// Largest number of added surfels as a fraction of max_gaussians.
inline constexpr double kMostUnseen = 0.2;

// Concatenates `first` and `second`, with the spherical harmonics degree of `first`.
SplatLayer joined(const SplatLayer& first, const SplatLayer& second);

// Opaque surfels of a scene with thin glass, including those of the transmittance layer.
SplatLayer seen_through_glass(const SplatScene& scene);

// Moves surfels from the transmittance to the end of the diffuse layer: those on the large planes or their extension that the
// diffuse layer with its glass occludes in all training photos. Without them, a wall seen only through thin glass is a hole for a
// new camera that looks past the glass. Through the glass they look the same, up to the spherical harmonics degree of the diffuse
// layer. Returns the ascending indices of the surfels that stay; at least one, so that the layer exists.
std::vector<uint32_t> bring_out_from_behind_glass(const Capture& capture, std::span<const ScenePlane> planes, SplatScene& scene);

// Returns at most `most` surfels for the diffuse layer, with one colour for all directions and initial materials; the cells grow
// until they fit. `shown`: the trained surfels without glass; glass would hide the content behind it, and the region would be
// inpainted. `background`: distance of the sky; 0 = no sky. `medium`: in front of the photos; the colours are those without it.
SplatLayer inpainted_planes(const SplatLayer& shown, const Capture& capture, std::span<const ScenePlane> planes,
                            double background, size_t most, const MediumCoefficients<double>* medium = nullptr);

}  // namespace vitrine
