#include "stages/mesh/mirror_shape.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/process.h"
#include "core/camera/projection.h"
#include "core/camera/view_set.h"
#include "core/image/exr.h"
#include "core/image/resample.h"
#include "core/math/median.h"
#include "core/mesh/mesh_topology.h"
#include "core/stereo/mask_silhouette.h"
#include "core/stereo/visible_paint.h"

namespace vitrine {

namespace {

constexpr int kMaskSide = 640, kLeastMaskSide = 160;  // of the masks that shape the hull, pixels
constexpr double kMostMaskPixels = 30e6;              // of all views together: about 16 bytes each
constexpr double kDissent = 0.15;                     // share of the photos that may contradict: silhouettes on mirrors are rough
constexpr int kHullResolution = 96, kHullBlur = 13;   // silhouettes of some dozen photos are facets: a bell of three voxels
constexpr float kHalf = 0.5f;
constexpr double kCells = 16;         // along the hull: places in neighbouring ones hang together
constexpr int kStride = 4;            // pixels of the masks between places that are looked at
constexpr double kLeastCosine = 0.3;  // of views that tell about a place
constexpr size_t kFewestViews = 4;
constexpr float kNoPaint = 0.65f;                 // of a part's lower-half mean ratio: less is metal
constexpr double kCrumb = 0.05;                   // of the places on the largest part: no thing of its own
constexpr double kOnShape = 2.5;                  // voxels: a blurred hull lies so far from the shape that it shows
constexpr int kMarksMargin = 2;                   // pixels of the masks: silhouettes may be too narrow by that
constexpr double kSteep = 0.7, kSteepest = 0.97;  // of a normal along the axis: no silhouette shows the tops of lids, and a
                                                  // smooth hull guesses better; from one to the other
constexpr double kTurnedAlike = 0.7;              // cosine between both normals, at least

}  // namespace

int mirror_mask_side(size_t views) {
  constexpr double kUsualShape = 0.75;  // height over width
  const double side = std::sqrt(kMostMaskPixels / (kUsualShape * double(std::max<size_t>(views, 1))));
  return int(std::clamp(side, double(kLeastMaskSide), double(kMaskSide)));
}

bool MirrorShape::Part::metal() const { return !coat && lower_half < kNoPaint; }

MirrorShape::MirrorShape(const MirrorShapeDesc& desc) {
  std::vector<Silhouette> silhouettes;
  std::vector<size_t> view_of;  // [silhouette]
  const int side = mirror_mask_side(desc.views.size());
  bool any = false;
  for (size_t i = 0; i < desc.views.size(); ++i) {
    throw_if_interrupted();
    const auto photo = std::ranges::find(desc.photos, desc.views[i].name, &View::name);
    VITRINE_CHECK(photo != desc.photos.end(), "no photo is called {}", desc.views[i].name);
    auto marks = mask_silhouette(desc.masks, MaskClass::Specular, *photo, desc.views[i].intrinsics.limited_to(side));
    marks_.push_back(marks ? marks->value : ImageF());
    any = any || (marks && marks_something(*marks));
    if (marks) silhouettes.push_back(std::move(*marks)), view_of.push_back(i);
  }
  if (!any) return;
  for (size_t s = 0; s < silhouettes.size(); ++s) {
    throw_if_interrupted();
    Silhouette& silhouette = silhouettes[s];
    const ImageF& marks = silhouette.value;
    silhouette.depth = ImageF(marks.width(), marks.height(), 1);
    const RgbdFrame frame = desc.frame_of(view_of[s]);
    const int width = frame.intrinsics.width, height = frame.intrinsics.height;
    for (int y = 0; y < marks.height(); ++y)
      for (int x = 0; x < marks.width(); ++x)
        silhouette.depth.at(x, y) =
            frame.zdepth[size_t(y * height / marks.height()) * size_t(width) + size_t(x * width / marks.width())];
  }
  hull_.emplace(silhouettes, HullDesc{.resolution = kHullResolution, .rule = {.dissent = kDissent}, .blur_passes = kHullBlur});
  if (hull_->empty()) return;
  find_parts(desc, silhouettes);
  find_shapes(desc);
}

CellIndex MirrorShape::cell_of(const Vec3d& p) const {
  return {int(std::floor(p.x / cell_)), int(std::floor(p.y / cell_)), int(std::floor(p.z / cell_))};
}

bool MirrorShape::metal_at(const Vec3d& place) const {
  const auto part = part_of_.find(cell_of(place));
  return part != part_of_.end() && part->second >= 0 && parts_[size_t(part->second)].metal();
}

// What the photos show of places on the hull, and which of these hang together.
void MirrorShape::find_parts(const MirrorShapeDesc& desc, const std::vector<Silhouette>& silhouettes) {
  const Vec3d extent = hull_->bounds().high - hull_->bounds().low;
  cell_ = std::max({extent.x, extent.y, extent.z}) / kCells;
  std::vector<ImageF> shown;  // [silhouette] luminance
  for (const Silhouette& o : silhouettes) {
    throw_if_interrupted();
    const ImageF photo = resized(read_exr_rgb(linear_image_path(desc.sfm, o.view)), o.value.width(), o.value.height());
    ImageF& grey = shown.emplace_back(photo.width(), photo.height(), 1);
    for (size_t p = 0; p < grey.data().size(); ++p)
      for (size_t c = 0; c < 3; ++c)  // negative: a colour outside of Rec. 709
        grey.data()[p] += std::max(photo.data()[3 * p + c], 0.f) / float(3 * o.view.gain[c]);
  }
  std::map<CellIndex, std::vector<float>> lower_half;
  std::vector<float> luminances;
  for (const Silhouette& from : silhouettes) {
    throw_if_interrupted();
    const Rigid world_from_cam = inverse(from.view.cam_from_world);
    for (int y = 0; y < from.value.height(); y += kStride)
      for (int x = 0; x < from.value.width(); x += kStride) {
        if (!(from.value.at(x, y) > kHalf)) continue;
        const Vec3d direction = world_from_cam.rotation * from.view.intrinsics.ray(x + 0.5, y + 0.5);
        const auto hit = hull_->first_hit(world_from_cam.translation, direction);
        if (!hit) continue;
        const Vec3d place = world_from_cam.translation + hit->t * direction;
        luminances.clear();
        for (size_t o = 0; o < silhouettes.size(); ++o) {
          const View& view = silhouettes[o].view;
          const auto at = image_point(place, view);
          if (!at || !(silhouettes[o].value.at(int(at->x), int(at->y)) > kHalf)) continue;
          if (dot(hit->normal, normalized(view.centre_in_world() - place)) < kLeastCosine) continue;
          luminances.push_back(shown[o].at(int(at->x), int(at->y)));
        }
        std::vector<float>& of_cell = lower_half[cell_of(place)];
        if (luminances.size() >= kFewestViews) of_cell.push_back(lower_half_mean_ratio(luminances));
      }
  }
  std::vector<CellIndex> cells;
  for (const auto& [cell, values] : lower_half) cells.push_back(cell);
  std::vector<size_t> places;  // [part]
  for (const auto& members : connected_cells(cells).members) {
    const int part = int(parts_.size());
    std::vector<float> all;
    parts_.emplace_back();
    for (size_t i : members) {
      const CellIndex& at = cells[i];
      part_of_[at] = part;
      all.insert(all.end(), lower_half[at].begin(), lower_half[at].end());
      for (int d = 0; d < 2; ++d)
        parts_.back().bounds.extend(cell_ * Vec3d{double(at[0] + d), double(at[1] + d), double(at[2] + d)});
    }
    if (!all.empty()) parts_.back().lower_half = upper_median(all);
    places.push_back(all.size());
  }
  // Crumbs where cones happen to meet.
  std::vector<int> number(parts_.size(), -1);
  size_t kept = 0;
  for (size_t p = 0; p < parts_.size(); ++p) {
    if (double(places[p]) < kCrumb * double(std::ranges::max(places))) continue;
    number[p] = int(kept);
    parts_[kept++] = parts_[p];
  }
  parts_.resize(kept);
  for (auto& [cell, part] : part_of_) part = number[size_t(part)];
}

// Parts most of which lies on coats.
void MirrorShape::mark_coats(const ShapeSet& shapes, const std::vector<ShapePoint>& surface) {
  std::vector<size_t> on_coat(parts_.size(), 0), all(parts_.size(), 0);
  for (const ShapePoint& p : surface) {
    const auto part = part_of_.find(cell_of(p.position));
    if (part == part_of_.end() || part->second < 0) continue;
    ++all[size_t(part->second)];
    on_coat[size_t(part->second)] += std::ranges::any_of(shapes.entries, [&](const ShapeSet::Entry& e) {
      const double near = std::max(e.tolerance, kOnShape * hull_->voxel());
      return e.role == ShapeRole::Coat && length(nearest(e.shape, p.position).position - p.position) <= near;
    });
  }
  for (size_t i = 0; i < parts_.size(); ++i) parts_[i].coat = 2 * on_coat[i] > all[i];
}

// Shapes that metal lies on, with their appendages; all that training learnt, which knows them for metal: a hull that merges them
// with a glazed thing beside does not.
void MirrorShape::find_shapes(const MirrorShapeDesc& desc) {
  const std::vector<ShapePoint> surface = hull_->surface();
  mark_coats(desc.found, surface);
  learnt_ = knows(desc.learnt, ShapeRole::Mirror);
  const ShapeSet found = (learnt_ ? *desc.learnt : desc.found).without(ShapeRole::Sheet).without(ShapeRole::Coat);
  std::vector<uint8_t> keep(found.entries.size(), 1);
  for (size_t i = 0; i < keep.size(); ++i) {
    if (found.entries[i].parent >= 0 || learnt_) continue;
    size_t metal = 0, known = 0;
    for (const ShapePoint& p : surface) {
      if (length(nearest(found.entries[i].shape, p.position).position - p.position) > kOnShape * hull_->voxel()) continue;
      const auto part = part_of_.find(cell_of(p.position));
      if (part == part_of_.end() || part->second < 0) continue;
      metal += parts_[size_t(part->second)].metal(), ++known;
    }
    keep[i] = 2 * metal > known;
  }
  shapes_ = found.kept(keep);
}

// Silhouettes that are too narrow by a pixel leave pictures in the mirror beside them, deep inside.
bool MirrorShape::near_marks(const ImageF& marks, int x, int y) const {
  for (int v = std::max(0, y - kMarksMargin); v <= std::min(marks.height() - 1, y + kMarksMargin); ++v)
    for (int u = std::max(0, x - kMarksMargin); u <= std::min(marks.width() - 1, x + kMarksMargin); ++u)
      if (marks.at(u, v) > kHalf) return true;
  return false;
}

size_t MirrorShape::put_vertices(TriMesh& mesh, double tolerance) const {
  if (!learnt_) return 0;
  const std::vector<Vec3f> normals = vertex_normals(mesh);
  size_t moved = 0;
  for (const bool appendages : {true, false})
    for (const ShapeSet::Entry& e : shapes_.entries) {
      if ((e.parent >= 0) != appendages) continue;
      for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const ShapePoint near = nearest(e.shape, cast<double>(mesh.positions[v]));
        if (length(near.position - cast<double>(mesh.positions[v])) > (appendages ? e.tolerance : tolerance)) continue;
        if (dot(near.normal, cast<double>(normals[v])) < kTurnedAlike) continue;  // the other side of a thin part, a rim
        if (!appendages) mesh.positions[v] = cast<float>(near.position);
        if (!mesh.normals.empty()) mesh.normals[v] = cast<float>(near.normal);
        ++moved;
      }
    }
  return moved;
}

// How much of the depth is the hull's where it lies on a shape, 0 to 1; nullopt: it does not.
std::optional<double> MirrorShape::hull_share(const ShapeSet::Entry& entry, const HullHit& hit, const Vec3d& place) const {
  const ShapePoint on = nearest(entry.shape, place);
  if (length(on.position - place) > kOnShape * hull_->voxel() || dot(on.normal, hit.normal) < kTurnedAlike) return std::nullopt;
  const auto* solid = std::get_if<SurfaceOfRevolution>(&entry.shape);
  if (learnt_ || !solid) return 0;
  const double steep = std::clamp((std::abs(dot(on.normal, solid->axis)) - kSteep) / (kSteepest - kSteep), 0.0, 1.0);
  return steep * steep * (3 - 2 * steep);
}

void MirrorShape::put(size_t i, RgbdFrame& frame, double tolerance) const {
  if ((std::ranges::none_of(parts_, &Part::metal) && shapes_.entries.empty()) || marks_[i].empty()) return;
  const bool all_metal = std::ranges::all_of(parts_, &Part::metal);
  const ImageF& marks = marks_[i];
  const Intrinsics& k = frame.intrinsics;
  const Rigid world_from_cam = inverse(frame.cam_from_world);
  const Vec3d& eye = world_from_cam.translation;
  const auto set = [&](size_t p, double t, const Vec3d& normal, const Vec3d& direction) {
    if (frame.zdepth[p] > 0 && frame.zdepth[p] < t - tolerance) return;  // something in front
    const double cosine = dot(normal, direction) / length(direction);
    frame.zdepth[p] = float(t);
    frame.weight[p] = float(cosine * cosine / (t * t));
  };
  parallel_for(size_t(k.height), 8, [&](size_t y) {
    for (int x = 0; x < k.width; ++x) {
      const int mx = x * marks.width() / k.width, my = int(y) * marks.height() / k.height;
      const float mark = marks.at(mx, my);
      if (mark < 0 || !near_marks(marks, mx, my)) continue;
      const size_t p = y * size_t(k.width) + size_t(x);
      const Vec3d direction = world_from_cam.rotation * k.ray(x + 0.5, double(y) + 0.5);  // z = 1: t is the z-depth
      const auto hit = hull_->first_hit(eye, direction);
      const Vec3d place = hit ? eye + hit->t * direction : Vec3d{};
      const Ray ray{eye, direction};
      if (const auto first = shapes_.first_hit(ray, ShapeRole::Mirror); first && shapes_.entries[first->entry].parent >= 0) {
        set(p, first->t, first->normal, direction);
        continue;
      }
      // A shape instead of the hull where that lies on it, or passes the ray by, or shows paint that silhouettes merge with it.
      const bool hull_tells = hit && metal_at(place);
      const auto share = [&](const ShapeSet::Entry& e) {
        return hull_tells ? hull_share(e, *hit, place) : std::optional<double>(0);
      };
      const auto shown = shapes_.first_hit(ray, ShapeRole::Mirror, [&](const ShapeSet::Hit& h) {
        return shapes_.entries[h.entry].parent < 0 && share(shapes_.entries[h.entry]).has_value();
      });
      if (shown) {
        const double hulls = *share(shapes_.entries[shown->entry]);
        set(p, hulls > 0 ? (1 - hulls) * shown->t + hulls * hit->t : shown->t, shown->normal, direction);
        continue;
      }
      const bool passed_by = hit && std::ranges::any_of(shapes_.entries, [&](const ShapeSet::Entry& e) {
                               return e.parent < 0 && hull_share(e, *hit, place).value_or(1) < 1;
                             });
      if (!(mark > kHalf)) continue;
      if (passed_by || !hit) {
        if (passed_by || all_metal) frame.weight[p] = 0;
        continue;
      }
      if (!hull_tells) continue;
      set(p, hit->t, hit->normal, direction);
    }
  });
}

}  // namespace vitrine
