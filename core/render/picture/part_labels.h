// Which object the parts of a scene belong to, by label images of its photos: surfels, vertices of a mesh, and places that no
// photo sees.
//   surfel   n_l = sum over all pixels with the label l of its blending weights, n_0 over the others. It belongs to the l of the
//            largest n_l if sum_{l > 0} n_l > 3 n_0, to none if that is below n_0 / 3; between them, at a silhouette, its place
//            decides.
//   vertex   the label of most photos in which the mesh does not hide it, if more show one than none
//   place    the label that 80 % of the photos have in front of it that have it in the picture, of three photos or more: the
//            visual hull. Surfels and vertices that no photo sees are such places.
// Pixels of thin glass show what stands behind it: where a scene has a transmittance layer, the surfels of thin glass are those
// that let light through (tau > 1/2), and what stands in it belongs to none.
// Equal counts: the smaller label. Labels are widened by a pixel: what stands on a silhouette falls on either side.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/objects/object_labels.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

struct LabelledView {
  View view;       // intrinsics of the size of the labels
  Image16 labels;  // [h,w,1] 0: none
};

// Of the photos that have labels, in pictures of at most 320 pixels a side; `photos` carry the size of their views.
std::vector<LabelledView> labelled_views(const LabelledObjects& objects, std::span<const View> photos);
inline constexpr int kLabelSide = 320;

struct SurfelLabels {
  std::vector<uint16_t> label;
  std::vector<uint8_t> seen;  // by some photo
};
// [surfels] `near_z`: of the rasteriser.
SurfelLabels labels_of_surfels(const SplatLayer& layer, float near_z, std::span<const LabelledView> views);
// [vertices]
std::vector<uint16_t> labels_of_vertices(const TriMesh& mesh, std::span<const LabelledView> views);
// [count] Of places that stand behind or inside of glass.
std::vector<uint16_t> labels_of_places(size_t count, const std::function<Vec3d(size_t)>& place,
                                       std::span<const LabelledView> views);

bool shows_thin_glass(const ObjectSet& objects, uint16_t label);
// 0 in place of the labels of thin glass.
void leave_out_thin_glass(const ObjectSet& objects, std::span<uint16_t> labels);
// Sets the ids of all surfels: those of the diffuse layer by what photos show, those of the transmittance layer by their places.
void assign_objects(const ObjectSet& objects, std::span<const LabelledView> views, float near_z, SplatLayer& diffuse,
                    SplatLayer& transmittance);

// [h,w] The object whose surfels blend to the largest weight in each pixel, 0 where those of none and what is behind all do.
Image16 rendered_objects(const SplatLayer& diffuse, float near_z, const View& view);

}  // namespace vitrine
