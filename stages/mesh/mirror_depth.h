// Depth of mirrors from their shapes (core/scene/objects), optimised by training if available. Surfels of a mirror represent
// virtual images, with wrong depths and normals, and relighting of metal depends on exact normals. Coats keep the depth of their
// surfels: a glazed pot is hollow, its visual hull is not.
#pragma once

#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/objects/object_labels.h"
#include "stages/mesh/fusion.h"

namespace vitrine {

class MirrorDepth {
 public:
  // `learnt`: optimised shapes (ImageOptions::shape), or nullptr. `views`: the fused views, at their size.
  MirrorDepth(LabelledObjects objects, const ShapeSet* learnt, const std::vector<View>& views);

  bool empty() const { return shapes_.entries.empty(); }
  // Sets the depth of the shape in the mirror pixels of view i, unless the frame has a surface more than `tolerance` in front of
  // it. Mirror pixels outside the shape are not fused.
  void put(size_t i, RgbdFrame& frame, double tolerance) const;
  // Moves vertices within `tolerance` of an optimised shape onto it and gives them its normals, because voxel terraces are
  // visible in a mirror. Vertices on an appendage get its normals. Returns their number.
  size_t put_vertices(TriMesh& mesh, double tolerance) const;

 private:
  LabelledObjects objects_;
  std::vector<View> views_;
  ShapeSet shapes_;              // of mirrors
  std::vector<uint8_t> learnt_;  // [entry] optimised by training, including the tops of lids, which no silhouette shows
};

}  // namespace vitrine
