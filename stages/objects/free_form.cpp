#include "stages/objects/free_form.h"

#include "core/base/log.h"
#include "core/mesh/clean_openmesh.h"
#include "core/stereo/mesh_fit.h"
#include "stages/objects/detect.h"
#include "stages/objects/fine_hull.h"

namespace vitrine {

namespace {

constexpr size_t kFaces = 6000;
constexpr double kTolerance_rel = 0.02;  // of the mesh's size: surfels that show it lie so near
constexpr double kLeastInside = 0.85;    // of its pixels, that the masks mark

}  // namespace

std::optional<ShapeSet::Entry> free_form(const MaskedObject& object, ShapeRole role) {
  TriMesh start = hull_mesh(object.hull);
  if (start.faces.empty()) return std::nullopt;
  if (start.faces.size() > kFaces) start = decimated(start, {.target_faces = kFaces});
  if (start.faces.empty()) return std::nullopt;
  const MeshFit fit = fit_mesh(object.silhouettes, std::move(start));
  TriangleShape shape(fit.mesh);
  const double size = shape.size();
  ShapeSet set;
  set.entries.push_back({.shape = std::move(shape), .role = role, .tolerance = kTolerance_rel * size, .clear = {}});
  const MaskAgreement agreement = mask_agreement(set, object.silhouettes);
  log_info("a mesh of size {:.2f}: {:.3f} of it inside the masks, residual {:.5f}, {:.2f} of its vertices seen at silhouettes",
           size, agreement.inside, fit.residual, fit.contacts);
  if (agreement.inside < kLeastInside) return std::nullopt;
  return std::move(set.entries.front());
}

}  // namespace vitrine
