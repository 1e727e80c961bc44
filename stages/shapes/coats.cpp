#include "stages/shapes/coats.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/base/process.h"
#include "core/camera/projection.h"
#include "core/camera/view_set.h"
#include "core/image/exr.h"
#include "core/image/resample.h"
#include "core/mesh/clean_openmesh.h"
#include "core/shape/surface_samples.h"
#include "stages/shapes/fine_hull.h"

namespace vitrine {

namespace {

constexpr int kPhotoSide = 240;              // pixels: texture that is off by less than one does not count as a change
constexpr double kSamples_rel = 1 / 24.0;    // of a shape's size: distance of the places that are looked at
constexpr float kWholePixel = 0.99f;         // of a pixel's area inside the mask
constexpr double kHullTolerance_voxels = 3;  // a hull stands out of its object by so much
constexpr size_t kMostHullFaces = 8000;

// The photo's pixels that the silhouette marks as a whole.
std::vector<uint8_t> marked_pixels(const Silhouette& silhouette, const Intrinsics& size) {
  ImageF marks = silhouette.value;
  for (float& value : marks.data()) value = value >= 0.5f ? 1.f : 0.f;
  const ImageF share = resized(marks, size.width, size.height);
  std::vector<uint8_t> out(share.data().size());
  std::ranges::transform(share.data(), out.begin(), [](float s) { return s > kWholePixel; });
  return out;
}

}  // namespace

CoatTest::CoatTest(const fs::path& sfm, std::span<const Silhouette> silhouettes) : photos_(silhouettes.size()) {
  parallel_for(silhouettes.size(), 1, [&](size_t i) {
    if (interrupt_signal() != 0) return;
    const Silhouette& s = silhouettes[i];
    photos_[i] = luminance_photo(s.view, read_exr_rgb(linear_image_path(sfm, s.view)), kPhotoSide);
    photos_[i].inside = marked_pixels(s, photos_[i].view.intrinsics);
  });
  throw_if_interrupted();
  spread_ = luminance_spread(photos_);
}

std::optional<double> CoatTest::view_dependence_of(const ShapeSet& all, uint32_t entry) const {
  std::vector<ShapePoint> surface;
  for (uint32_t i = 0; i < all.entries.size(); ++i) {
    if (all.root(i) != entry) continue;
    const Shape& shape = all.entries[i].shape;
    const std::vector<ShapePoint> own = surface_samples(shape, kSamples_rel * size_of(shape));
    surface.insert(surface.end(), own.begin(), own.end());
  }
  const double slack = all.entries[entry].tolerance;
  return view_dependence(surface, {.photos = photos_, .photo_spread = spread_, .hidden = [&](size_t photo, const Vec3d& p) {
                                     const Vec3d eye = photos_[photo].view.centre_in_world(), way = p - eye;
                                     const double far_enough = 1 - slack / length(way);
                                     return std::ranges::any_of(all.entries, [&](const ShapeSet::Entry& e) {
                                       if (e.role == ShapeRole::Sheet) return false;
                                       const auto hit = intersect(e.shape, {eye, way});
                                       return hit && hit->t < far_enough;
                                     });
                                   }});
}

std::optional<double> CoatTest::view_dependence_of(const MaskedObject& object) const {
  const double slack = kHullTolerance_voxels * object.hull.voxel();
  return view_dependence(object.hull.surface(),
                         {.photos = photos_, .photo_spread = spread_, .hidden = [&](size_t photo, const Vec3d& p) {
                            const Vec3d eye = photos_[photo].view.centre_in_world(), way = p - eye;
                            const Silhouette& own = object.silhouettes[photo];
                            const auto at = image_point(p, own.view);
                            if (!at || own.value.at(int(at->x), int(at->y)) < 0.5f) return true;  // another object may show
                            const auto hit = object.hull.first_hit(eye, way);
                            return hit && hit->t < 1 - slack / length(way);
                          }});
}

ShapeSet hull_coat(const MaskedObject& object) {
  TriMesh mesh = hull_mesh(object.hull);
  if (mesh.faces.size() > kMostHullFaces) mesh = decimated(mesh, {.target_faces = kMostHullFaces});
  ShapeSet out;
  if (mesh.faces.empty()) return out;
  out.entries.push_back({.shape = TriangleShape(std::move(mesh)),
                         .role = ShapeRole::Coat,
                         .tolerance = kHullTolerance_voxels * object.hull.voxel(),
                         .clear = {},
                         .exact = false});
  return out;
}

}  // namespace vitrine
