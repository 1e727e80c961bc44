#include "stages/objects/objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/image/contact_sheet.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

namespace {

constexpr int kCellWidth = 480;  // pixels
constexpr size_t kPhotos = 8;
constexpr double kFewestNamed = 200;  // minimum pixels of an object with a name label
constexpr std::array<std::array<uint8_t, 3>, kObjectRoles> kRoleColors{
    {{160, 160, 160}, {0, 178, 255}, {0, 110, 255}, {255, 115, 0}, {90, 220, 60}}};  // [ObjectRole]
constexpr float kTint = 0.35f, kPaleTint = 0.15f;                                    // opacity of the role colour

// Silhouette pixels: the right or lower neighbour belongs to another entry.
void draw_silhouettes(const ObjectSet& set, const View& view, Image8& picture) {
  const ShapeSet& shapes = set.shapes;
  const Intrinsics& k = view.intrinsics;
  constexpr int kNone = -1;
  std::vector<int> shown(k.pixel_count(), kNone);
  mask_of_rays(view, [&](size_t pixel, const Vec3d& eye, const Vec3d& direction) {
    double t = 1e300;
    for (size_t i = 0; i < shapes.entries.size(); ++i)
      if (const auto hit = intersect(shapes.entries[i].shape, {eye, direction}); hit && hit->t < t)
        t = hit->t, shown[pixel] = int(i);
    return false;
  });
  const auto at = [&](int x, int y) {
    return shown[size_t(std::min(y, k.height - 1)) * size_t(k.width) + size_t(std::min(x, k.width - 1))];
  };
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const int here = at(x, y);
      const int other = at(x + 1, y) != here ? at(x + 1, y) : at(x, y + 1);
      if (other == here) continue;
      const Object* object = set.of_shape(size_t(std::max(here, other)));
      const auto& color = kRoleColors[object != nullptr ? static_cast<size_t>(object->role) : 0];
      for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx)
          for (int c = 0; c < 3; ++c)
            picture.at(std::min(x + dx, k.width - 1), std::min(y + dy, k.height - 1), c) = color[size_t(c)];
    }
}

// Tints the pixels of each object and writes its name at their centroid.
void draw_labels(const ObjectSet& set, const Image16& labels, Image8& picture) {
  struct Middle {
    double x = 0, y = 0, count = 0;
  };
  std::map<uint16_t, Middle> middles;
  for (int y = 0; y < labels.height(); ++y)
    for (int x = 0; x < labels.width(); ++x) {
      const Object* object = set.find(labels.at(x, y));
      if (object == nullptr) continue;
      Middle& m = middles[object->id];
      m.x += x, m.y += y, ++m.count;
      const float tint = object->trust == ObjectTrust::Guessed ? kPaleTint : kTint;
      const auto& color = kRoleColors[static_cast<size_t>(object->role)];
      for (int c = 0; c < 3; ++c)
        picture.at(x, y, c) = uint8_t(std::lround((1 - tint) * float(picture.at(x, y, c)) + tint * float(color[size_t(c)])));
    }
  for (const auto& [id, m] : middles)
    if (m.count >= kFewestNamed) draw_text(picture, int(m.x / m.count), int(m.y / m.count), set.find(id)->name, 1, 255);
}

}  // namespace

void write_contact_sheet(const fs::path& file, const fs::path& sfm, const ViewSet& set, const LabelledObjects& objects) {
  const size_t count = std::min(kPhotos, set.views.size());
  std::vector<Image8> cells(count);
  std::vector<std::string> names(count);
  parallel_for(count, 1, [&](size_t i) {
    View view = set.views[i * set.views.size() / count];
    names[i] = view.name;
    const ImageF linear = read_exr_rgb(linear_image_path(sfm, view));
    view.intrinsics = view.intrinsics.limited_to(kCellWidth);
    cells[i] = srgb8_from_linear(resized(linear, view.intrinsics.width, view.intrinsics.height));
    const Image16 labels = objects.labels(view, view.intrinsics);
    if (!labels.empty()) draw_labels(objects.objects(), labels, cells[i]);
    draw_silhouettes(objects.objects(), view, cells[i]);
  });
  ContactSheet sheet(2, kCellWidth);
  sheet.start_row("BLUE GLASS, ORANGE MIRROR, GREEN COAT");
  for (size_t i = 0; i < count; ++i) sheet.add(names[i], cells[i]);
  sheet.write(file);
}

}  // namespace vitrine
