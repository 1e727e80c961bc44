#include "stages/objects/roles.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/projection.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/resample.h"
#include "core/scene/shape/shape_set.h"
#include "stages/objects/detect.h"

namespace vitrine {

namespace {

constexpr int kPhotoSide = 240;            // pixels: at this size a misalignment below one pixel hardly changes the luminance
constexpr double kSamples_rel = 1 / 24.0;  // of a shape's size: spacing of the surface samples
constexpr float kWholePixel = 0.99f;       // of a pixel's area inside the mask

// Pixels of the photo that lie completely inside the silhouette.
std::vector<uint8_t> marked_pixels(const Silhouette& silhouette, const Intrinsics& size) {
  ImageF marks = silhouette.value;
  for (float& value : marks.data()) value = value >= 0.5f ? 1.f : 0.f;
  const ImageF share = resized(marks, size.width, size.height);
  std::vector<uint8_t> out(share.data().size());
  std::ranges::transform(share.data(), out.begin(), [](float s) { return s > kWholePixel; });
  return out;
}

}  // namespace

RoleTest::RoleTest(const fs::path& sfm, std::span<const Silhouette> silhouettes) : photos_(silhouettes.size()) {
  parallel_for(silhouettes.size(), 1, [&](size_t i) {
    if (interrupt_signal() != 0) return;
    const Silhouette& s = silhouettes[i];
    photos_[i] = luminance_photo(s.view, read_exr_rgb(linear_image_path(sfm, s.view)), kPhotoSide);
    photos_[i].inside = marked_pixels(s, photos_[i].view.intrinsics);
  });
  throw_if_interrupted();
  spread_ = luminance_spread(photos_);
}

std::optional<double> RoleTest::view_dependence(const ShapeSet& all, uint16_t object) const {
  std::vector<ShapePoint> surface;
  double slack = 0;
  for (const ShapeSet::Entry& entry : all.entries) {
    if (entry.object != object) continue;
    const std::vector<ShapePoint> own = surface_samples(entry.shape, kSamples_rel * size_of(entry.shape));
    surface.insert(surface.end(), own.begin(), own.end());
    if (entry.parent < 0) slack = std::max(slack, entry.tolerance);
  }
  return vitrine::view_dependence(surface,
                                  {.photos = photos_, .photo_spread = spread_, .hidden = [&](size_t photo, const Vec3d& p) {
                                     const Vec3d eye = photos_[photo].view.centre_in_world(), way = p - eye;
                                     const double far_enough = 1 - slack / length(way);
                                     return std::ranges::any_of(all.entries, [&](const ShapeSet::Entry& e) {
                                       if (is_glass(e.role)) return false;
                                       const auto hit = intersect(e.shape, {eye, way});
                                       return hit && hit->t < far_enough;
                                     });
                                   }});
}

std::optional<double> RoleTest::view_dependence(const MaskedObject& object) const {
  const double slack = kHullTolerance_voxels * object.hull.voxel();
  return vitrine::view_dependence(object.hull.surface(),
                                  {.photos = photos_, .photo_spread = spread_, .hidden = [&](size_t photo, const Vec3d& p) {
                                     const Vec3d eye = photos_[photo].view.centre_in_world(), way = p - eye;
                                     const Silhouette& own = object.silhouettes[photo];
                                     const auto at = image_point(p, own.view);
                                     if (!at || own.value.at(int(at->x), int(at->y)) < 0.5f)
                                       return true;  // another object may be visible
                                     const auto hit = object.hull.first_hit(eye, way);
                                     return hit && hit->t < 1 - slack / length(way);
                                   }});
}

ObjectRole object_role_of(MaskClass kind, const std::optional<double>& view_dependence, bool exact, double coat_below) {
  if (kind == MaskClass::Transparent) return ObjectRole::ThinGlass;
  const bool paint = view_dependence ? *view_dependence < coat_below : !exact;
  return paint ? ObjectRole::Coat : ObjectRole::Mirror;
}

}  // namespace vitrine
