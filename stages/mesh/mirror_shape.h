// The shape of polished metal. What surfels learn there are pictures in the mirror, at their depths and with their normals; what
// photos tell of the metal itself is its silhouette. Where the masks stage marks mirrors that are not glass, the fused depth is
// that of the visual hull of their silhouettes (core/stereo/visual_hull) and, where that lies on a solid of revolution, of the
// solid, which neither bulges nor wavers (core/stereo/revolution_fit), as training learnt it from what it mirrors where it did:
// relit metal is what its normals make it; photos in which something dull stands in front, or glass, say nothing there. Parts of
// the hull that show paint (core/stereo/visible_paint) keep their depth: a glazed pot is hollow, its hull is not.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/math/connected_components.h"
#include "core/mesh/tri_mesh.h"
#include "core/shape/shape_set.h"
#include "core/stereo/visual_hull.h"
#include "stages/mesh/rgbd_frame.h"

namespace vitrine {

struct MirrorShapeDesc {
  const std::filesystem::path& sfm;  // artifacts of these stages
  const std::filesystem::path& masks;
  const std::vector<View>& photos;            // at full size
  const std::vector<View>& views;             // those that are fused
  const ShapeSet* learnt;                     // by training (ImageOptions::shape), or nullptr
  ShapeSet found;                             // before training
  std::function<RgbdFrame(size_t)> frame_of;  // what surfels learnt of them
};

// Longest side of the masks: smaller where there are many views, so that memory stays within bounds.
int mirror_mask_side(size_t views);

class MirrorShape {
 public:
  explicit MirrorShape(const MirrorShapeDesc& desc);

  struct Part {
    Bounds3 bounds;
    bool coat = false;     // the shapes stage found paint under a clear layer there, or a person said so
    float lower_half = 1;  // lower-half mean ratio of what photos show of a place, in the median
    bool metal() const;
  };
  const std::vector<Part>& parts() const {
    return parts_;
  }  // connected ones; none: nothing is marked, or the silhouettes do not close

  // Puts the hull's depth, or a shape's, where view i marks metal, but where the frame knows a surface more than `tolerance` in
  // front of it. Marked pixels beside the hull are not fused, where all of it is metal; nor those beside a shape where the hull
  // lies on it.
  void put(size_t i, RgbdFrame& frame, double tolerance) const;
  // Vertices no further than `tolerance` from a shape that training learnt lie on it, and have its normals: voxels leave terraces
  // that a mirror shows. Those on its appendages have normals of these. Returns how many.
  size_t put_vertices(TriMesh& mesh, double tolerance) const;

 private:
  CellIndex cell_of(const Vec3d& p) const;
  bool metal_at(const Vec3d& place) const;  // of the hull
  void find_parts(const MirrorShapeDesc& desc, const std::vector<Silhouette>& silhouettes);
  void mark_coats(const ShapeSet& shapes, const std::vector<ShapePoint>& surface);
  void find_shapes(const MirrorShapeDesc& desc);
  std::optional<double> hull_share(const ShapeSet::Entry& entry, const HullHit& hit, const Vec3d& place) const;
  bool near_marks(const ImageF& marks, int x, int y) const;

  std::vector<ImageF> marks_;  // [view] at most mirror_mask_side large: coverage by mirrors, -1 glass; empty: unmarked
  std::optional<VisualHull> hull_;
  ShapeSet shapes_;      // of metal, of role Mirror
  bool learnt_ = false;  // by training: the tops of lids as well, which no silhouette shows
  double cell_ = 1;
  std::map<CellIndex, int> part_of_;
  std::vector<Part> parts_;
};

}  // namespace vitrine
