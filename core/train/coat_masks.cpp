#include "core/train/coat_masks.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace vitrine {

namespace {

constexpr int kOwnerSide = 240;  // pixels, longest side, of the map of owners
constexpr int kRimReach = 3;     // of its pixels: masks are wider than the silhouettes of shapes by so much

enum class Owner : uint8_t { Nothing, Mirror, Coat };

struct OwnerMap {
  Intrinsics size;
  std::vector<Owner> owner;  // [h,w]

  Owner at(int x, int y) const {
    if (x < 0 || y < 0 || x >= size.width || y >= size.height) return Owner::Nothing;
    return owner[size_t(y) * size_t(size.width) + size_t(x)];
  }
  // The nearest one within `reach`, where the pixel itself has none.
  Owner near(int x, int y, int reach) const {
    if (const Owner own = at(x, y); own != Owner::Nothing) return own;
    Owner found = Owner::Nothing;
    int nearest = reach * reach + 1;
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx)
        if (const Owner o = at(x + dx, y + dy); o != Owner::Nothing && dx * dx + dy * dy < nearest)
          nearest = dx * dx + dy * dy, found = o;
    return found;
  }
};

bool marked(const std::vector<uint8_t>& mask, const Intrinsics& k, int x, int y, const Intrinsics& small) {
  const int from_x = x * k.width / small.width, to_x = std::max((x + 1) * k.width / small.width, from_x + 1);
  const int from_y = y * k.height / small.height, to_y = std::max((y + 1) * k.height / small.height, from_y + 1);
  for (int v = from_y; v < std::min(to_y, k.height); ++v)
    for (int u = from_x; u < std::min(to_x, k.width); ++u)
      if (mask[size_t(v) * size_t(k.width) + size_t(u)] != 0) return true;
  return false;
}

// Of the pixels that the mask marks.
OwnerMap owners(const View& view, const std::vector<uint8_t>& mask, const ShapeSet& shapes) {
  const Intrinsics& k = view.intrinsics;
  OwnerMap out{k.limited_to(kOwnerSide), {}};
  out.owner.assign(size_t(out.size.width) * size_t(out.size.height), Owner::Nothing);
  const Vec3d eye = view.centre_in_world();
  for (int y = 0; y < out.size.height; ++y)
    for (int x = 0; x < out.size.width; ++x) {
      if (!marked(mask, k, x, y, out.size)) continue;
      const Ray ray{eye, transposed_times(view.cam_from_world.rotation, out.size.ray(x + 0.5, y + 0.5))};
      const auto coat = shapes.first_hit(ray, ShapeRole::Coat), mirror = shapes.first_hit(ray, ShapeRole::Mirror);
      Owner& owner = out.owner[size_t(y) * size_t(out.size.width) + size_t(x)];
      if (coat && (!mirror || coat->t <= mirror->t))
        owner = Owner::Coat;
      else if (mirror)
        owner = Owner::Mirror;
    }
  return out;
}

void separate(const OwnerMap& map, const Intrinsics& k, TargetLevel& level) {
  std::vector<uint8_t>& specular = level.masks[size_t(MaskClass::Specular)];
  const Intrinsics& small = map.size;
  const int reach = kRimReach + small.width / k.width;  // of small pictures one pixel is several of the map
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const size_t i = size_t(y) * size_t(k.width) + size_t(x);
      if (specular[i] == 0) continue;
      const int u = (2 * x + 1) * small.width / (2 * k.width), v = (2 * y + 1) * small.height / (2 * k.height);
      if (map.near(u, v, reach) == Owner::Mirror) continue;
      level.coat.resize(specular.size(), 0);
      std::swap(level.coat[i], specular[i]);
    }
}

}  // namespace

void separate_coats(const Capture& capture, const ShapeSet& shapes, Targets& targets) {
  parallel_for(targets.photos.size(), 1, [&](size_t photo) {
    auto& levels = targets.photos[photo];
    const std::vector<uint8_t>& whole = levels[0].masks[size_t(MaskClass::Specular)];
    if (whole.empty()) return;
    const OwnerMap map = owners(capture.photos[photo].levels[0].view, whole, shapes);
    for (size_t l = 0; l < levels.size(); ++l)
      if (!levels[l].masks[size_t(MaskClass::Specular)].empty())
        separate(map, capture.photos[photo].levels[l].view.intrinsics, levels[l]);
  });
}

}  // namespace vitrine
