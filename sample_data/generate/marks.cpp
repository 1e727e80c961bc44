#include "sample_data/generate/marks.h"

#include <algorithm>
#include <map>
#include <optional>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "core/scene/camera/panorama_views.h"
#include "core/scene/camera/projection.h"

namespace vitrine::generate {

namespace {

constexpr float kLoose = 0.1f;
constexpr size_t kMarked = 3;     // photos
constexpr int kHeldOutEvery = 8;  // nobody marks photos that judge
constexpr uint64_t kSeed = 0x3a7c5;

struct Thing {
  bool glass = false;
  std::vector<const Part*> parts;
};

struct PhotoBox {
  size_t view;
  double left, top, right, bottom;
};

// nullopt: not all of it is in the picture.
std::optional<PhotoBox> box_of(const Thing& thing, const Scene& scene, size_t v) {
  PhotoBox box{v, 1e300, 1e300, -1e300, -1e300};
  for (const Part* part : thing.parts)
    for (const Vec3f& p : part->shape.mesh.positions) {
      const auto at = image_point(cast<double>(p), scene.views[v], 0, 1);
      if (!at) return std::nullopt;
      box.left = std::min(box.left, at->x), box.right = std::max(box.right, at->x);
      box.top = std::min(box.top, at->y), box.bottom = std::max(box.bottom, at->y);
    }
  return box;
}

}  // namespace

void write_marks(const Scene& scene, const std::filesystem::path& file) {
  std::map<std::string, Thing> things;
  for (const Part& part : scene.parts) {
    const size_t slash = part.name.find('/');
    if (slash == std::string::npos || !part.material.glossy()) continue;
    Thing& thing = things[part.name.substr(0, slash)];
    thing.glass = thing.glass || part.material.glass();
    thing.parts.push_back(&part);
  }
  std::string text;
  Rng random(kSeed);
  for (const auto& [name, thing] : things) {
    std::vector<PhotoBox> whole;
    for (size_t v = 0; v < scene.views.size(); ++v)
      if (!is_heldout(scene.panoramas.empty() ? v : v / kPanoramaViews, kHeldOutEvery))
        if (const auto box = box_of(thing, scene, v)) whole.push_back(*box);
    if (whole.size() < kMarked) continue;
    for (size_t m = 0; m < kMarked; ++m) {
      const PhotoBox& box = whole[(2 * m + 1) * whole.size() / (2 * kMarked)];
      const Intrinsics& k = scene.views[box.view].intrinsics;
      const double width = box.right - box.left, height = box.bottom - box.top;
      const auto loose = [&](double size) { return size * double(kLoose * random.uniform()); };
      const double left = std::max(0.0, box.left - loose(width)), top = std::max(0.0, box.top - loose(height));
      const double right = std::min(double(k.width), box.right + loose(width)),
                   bottom = std::min(double(k.height), box.bottom + loose(height));
      text += fmt::format("  - {{photo: {}, class: {}, thing: {}, box: [{:.1f}, {:.1f}, {:.1f}, {:.1f}]}}\n",
                          scene.views[box.view].name, thing.glass ? "transparent" : "specular", name, left, top, right, bottom);
    }
  }
  if (text.empty()) return;
  const Intrinsics& k = scene.views.front().intrinsics;
  write_file(file, fmt::format("size: [{}, {}]\nmarks:\n{}", k.width, k.height, text));
}

}  // namespace vitrine::generate
