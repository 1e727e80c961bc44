// Depth of mirrors. What surfels learn there are pictures in the mirror, at their depths and with their normals: the fused depth
// of a mirror (core/scene/objects) is that of its shape, as training learnt it from what it mirrors where it did. Relit metal is what
// its normals make it. Coats keep the depth of their surfels: a glazed pot is hollow, its visual hull is not.
#pragma once

#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/objects/object_labels.h"
#include "stages/mesh/fusion.h"

namespace vitrine {

class MirrorDepth {
 public:
  // `learnt`: shapes of training (ImageOptions::shape), or nullptr. `views`: those that are fused, at their size.
  MirrorDepth(LabelledObjects objects, const ShapeSet* learnt, const std::vector<View>& views);

  bool empty() const { return shapes_.entries.empty(); }
  // Puts the depth of a shape where view i shows a mirror, but where the frame knows a surface more than `tolerance` in front of
  // it. Pixels of a mirror beside its shape are not fused.
  void put(size_t i, RgbdFrame& frame, double tolerance) const;
  // Vertices no further than `tolerance` from a shape that training learnt lie on it, and have its normals: voxels leave terraces
  // that a mirror shows. Those on its appendages have normals of these. Returns how many.
  size_t put_vertices(TriMesh& mesh, double tolerance) const;

 private:
  LabelledObjects objects_;
  std::vector<View> views_;
  ShapeSet shapes_;              // of mirrors
  std::vector<uint8_t> learnt_;  // [entry] by training: the tops of lids as well, which no silhouette shows
};

}  // namespace vitrine
