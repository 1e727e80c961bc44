#include "stages/objects/objects.h"

#include <algorithm>
#include <array>

#include "core/scene/camera/view_masks.h"
#include "core/scene/objects/object_labels.h"

namespace vitrine {

namespace {

constexpr int kOwnerSide = 240;  // pixels, longest side, of the owner map
constexpr int kRimReach = 3;     // of its pixels: masks exceed the silhouettes of shapes by up to this distance
constexpr float kMarked = 0.5f;

// Owner map: the first shape of a class on each ray of a photo.
class Owners {
 public:
  Owners(const View& photo, const ObjectSet& set, bool glass, const std::vector<uint8_t>& marked)
      : photo_(photo), small_(photo.intrinsics.limited_to(kOwnerSide)), eye_(photo.centre_in_world()) {
    for (const ShapeSet::Entry& e : set.shapes.entries)
      if (is_glass(e.role) == glass) shapes_.push_back(&e);
    owner_.assign(small_.pixel_count(), 0);
    if (shapes_.empty()) return;
    for (int y = 0; y < small_.height; ++y)
      for (int x = 0; x < small_.width; ++x)
        if (any_marked(marked, x, y)) owner_[at(x, y)] = first_along(small_.ray(x + 0.5, y + 0.5));
  }

  // Object at a full-size pixel; 0: none.
  uint16_t of(int x, int y) const {
    if (shapes_.empty()) return 0;
    const Intrinsics& k = photo_.intrinsics;
    const int u = (2 * x + 1) * small_.width / (2 * k.width), v = (2 * y + 1) * small_.height / (2 * k.height);
    const uint16_t own = owner_[at(u, v)];
    for (int j = std::max(v - 1, 0); j <= std::min(v + 1, small_.height - 1); ++j)
      for (int i = std::max(u - 1, 0); i <= std::min(u + 1, small_.width - 1); ++i)
        if (owner_[at(i, j)] != own)
          if (const uint16_t exact = first_along(k.ray(x + 0.5, y + 0.5)); exact != 0) return exact;
    return own != 0 ? own : nearest(u, v);
  }

 private:
  size_t at(int x, int y) const { return small_.index(x, y); }

  bool any_marked(const std::vector<uint8_t>& marked, int x, int y) const {
    const Intrinsics& k = photo_.intrinsics;
    const int from_x = x * k.width / small_.width, to_x = std::max((x + 1) * k.width / small_.width, from_x + 1);
    const int from_y = y * k.height / small_.height, to_y = std::max((y + 1) * k.height / small_.height, from_y + 1);
    for (int v = from_y; v < std::min(to_y, k.height); ++v)
      for (int u = from_x; u < std::min(to_x, k.width); ++u)
        if (marked[size_t(v) * size_t(k.width) + size_t(u)]) return true;
    return false;
  }

  uint16_t first_along(const Vec3d& in_camera) const {
    const Ray ray{eye_, transposed_times(photo_.cam_from_world.rotation, in_camera)};
    uint16_t object = 0;
    double t = INFINITY;
    for (const ShapeSet::Entry* e : shapes_)
      if (const auto hit = intersect(e->shape, ray); hit && hit->t < t) t = hit->t, object = e->object;
    return object;
  }

  uint16_t nearest(int u, int v) const {
    uint16_t found = 0;
    int least = kRimReach * kRimReach + 1;
    for (int j = std::max(v - kRimReach, 0); j <= std::min(v + kRimReach, small_.height - 1); ++j)
      for (int i = std::max(u - kRimReach, 0); i <= std::min(u + kRimReach, small_.width - 1); ++i) {
        const int away = (i - u) * (i - u) + (j - v) * (j - v);
        if (owner_[at(i, j)] != 0 && away < least) least = away, found = owner_[at(i, j)];
      }
    return found;
  }

  const View& photo_;
  Intrinsics small_;
  Vec3d eye_;
  std::vector<const ShapeSet::Entry*> shapes_;
  std::vector<uint16_t> owner_;  // [h,w] of small_
};

}  // namespace

Image16 labelled_pixels(const std::filesystem::path& masks, const View& photo, const ObjectSet& set,
                        const UnlocatedObjects& unlocated) {
  Image16 out;
  // Glass last: it is in front.
  for (const bool glass : {false, true}) {
    const auto mask = read_view_mask(masks, glass ? MaskClass::Transparent : MaskClass::Specular, photo);
    if (!mask) continue;
    if (out.empty()) out = Image16(mask->width(), mask->height(), 1);
    std::vector<uint8_t> marked(mask->pixel_count());
    std::ranges::transform(mask->data(), marked.begin(), [](float m) { return m >= kMarked; });
    const Owners owners(photo, set, glass, marked);
    for (int y = 0; y < mask->height(); ++y)
      for (int x = 0; x < mask->width(); ++x) {
        if (!marked[size_t(y) * size_t(mask->width()) + size_t(x)]) continue;
        const uint16_t owner = owners.of(x, y);
        out.at(x, y) = owner != 0 ? owner : glass ? unlocated.glass : unlocated.specular;
      }
  }
  return out;
}

}  // namespace vitrine
