#include "stages/mesh/fusion.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"
#include "core/scene/mesh/mesh_topology.h"

namespace vitrine {

namespace {

constexpr int kMirrorLabelSide = 640;  // longest side of the label images, pixels
constexpr int kLabelMargin = 2;        // label pixels: tolerance for too narrow silhouettes
constexpr double kTurnedAlike = 0.7;   // minimum cosine between the normals of a vertex and of the shape

bool has_object(const ShapeSet& set, uint16_t object) {
  return std::ranges::any_of(set.entries, [&](const ShapeSet::Entry& e) { return e.object == object; });
}

// Label of a pixel; next to an object, the object's label. At silhouettes that are a pixel too narrow, virtual images far behind
// the surface would remain.
uint16_t label_near(const Image16& labels, int x, int y) {
  if (labels.at(x, y) != 0) return labels.at(x, y);
  for (int v = std::max(0, y - kLabelMargin); v <= std::min(labels.height() - 1, y + kLabelMargin); ++v)
    for (int u = std::max(0, x - kLabelMargin); u <= std::min(labels.width() - 1, x + kLabelMargin); ++u)
      if (labels.at(u, v) != 0) return labels.at(u, v);
  return 0;
}

}  // namespace

MirrorDepth::MirrorDepth(LabelledObjects objects, const ShapeSet* learnt, const std::vector<View>& views)
    : objects_(std::move(objects)), views_(views) {
  const auto mirrors = [](const ShapeSet& set) { return set.no_glass().without(ShapeRole::Coat); };
  if (learnt != nullptr) shapes_ = mirrors(*learnt);
  learnt_.assign(shapes_.entries.size(), 1);
  ShapeSet found = mirrors(objects_.objects().shapes);
  std::vector<uint8_t> keep(found.entries.size());
  for (size_t i = 0; i < keep.size(); ++i) keep[i] = !has_object(shapes_, found.entries[i].object);
  shapes_.append(found.kept(keep));
  learnt_.resize(shapes_.entries.size(), 0);
}

void MirrorDepth::put(size_t i, RgbdFrame& frame, double tolerance) const {
  const View& view = views_[i];
  const Image16 labels = objects_.labels(view, view.intrinsics.limited_to(kMirrorLabelSide));
  if (empty() || labels.empty()) return;
  const Intrinsics& k = frame.intrinsics;
  const Rigid world_from_cam = inverse(frame.cam_from_world);
  const Vec3d& eye = world_from_cam.translation;
  parallel_for(size_t(k.height), 8, [&](size_t y) {
    for (int x = 0; x < k.width; ++x) {
      const int u = x * labels.width() / k.width, v = int(y) * labels.height() / k.height;
      const uint16_t id = label_near(labels, u, v);
      const Object* object = objects_.objects().find(id);
      if (object == nullptr || object->role != ObjectRole::Mirror || !has_object(shapes_, id)) continue;
      const size_t p = y * size_t(k.width) + size_t(x);
      const Vec3d direction = world_from_cam.rotation * k.ray(x + 0.5, double(y) + 0.5);  // z = 1: t is the z-depth
      const auto hit = shapes_.first_hit({eye, direction}, ShapeRole::Mirror,
                                         [&](const ShapeSet::Hit& h) { return shapes_.entries[h.entry].object == id; });
      if (!hit) {
        if (labels.at(u, v) == id) frame.weight[p] = 0;
        continue;
      }
      if (frame.zdepth[p] > 0 && frame.zdepth[p] < hit->t - tolerance) continue;  // an occluder
      const double cosine = dot(hit->normal, direction) / length(direction);
      frame.zdepth[p] = float(hit->t);
      frame.weight[p] = float(cosine * cosine / (hit->t * hit->t));
    }
  });
}

size_t MirrorDepth::put_vertices(TriMesh& mesh, double tolerance) const {
  if (std::ranges::count(learnt_, 1) == 0) return 0;
  const std::vector<Vec3f> normals = vertex_normals(mesh);
  size_t moved = 0;
  for (const bool appendages : {true, false})
    for (size_t entry = 0; entry < shapes_.entries.size(); ++entry) {
      const ShapeSet::Entry& e = shapes_.entries[entry];
      if (!learnt_[entry] || (e.parent >= 0) != appendages) continue;
      for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const ShapePoint near = nearest(e.shape, cast<double>(mesh.positions[v]));
        if (length(near.position - cast<double>(mesh.positions[v])) > (appendages ? e.tolerance : tolerance)) continue;
        if (dot(near.normal, cast<double>(normals[v])) < kTurnedAlike) continue;  // the other side of a thin part, or an edge
        if (!appendages) mesh.positions[v] = cast<float>(near.position);
        if (!mesh.normals.empty()) mesh.normals[v] = cast<float>(near.normal);
        ++moved;
      }
    }
  return moved;
}

}  // namespace vitrine
