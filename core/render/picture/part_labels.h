// Assigns the parts of a scene (surfels, mesh vertices, unseen positions) to objects, from label images of its photos.
//   surfel   n_l = sum of its blending weights over all pixels with label l, n_0 over unlabelled pixels. It belongs to the l
//            with the largest n_l if sum_{l > 0} n_l > 3 n_0, to no object if that sum is below n_0 / 3; between them, at a
//            silhouette, its position decides.
//   vertex   the label in most photos where the mesh does not occlude it, if more photos label it than not
//   position the label that 80 % of the photos have whose frustum contains the position, with at least three photos: the
//            visual hull. Also used for surfels and vertices that no photo sees.
// Pixels of thin glass show the scene behind it: if a scene has a transmittance layer, the surfels of thin glass are the
// transmissive ones (tau > 1/2), and objects seen in it are not assigned to it.
// Ties: the smaller label. Labels are dilated by a pixel, since surfels on a silhouette fall on either side.
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
  View view;       // intrinsics at the size of the labels
  Image16 labels;  // [h,w,1] 0: none
};

// Label images of the labelled photos, at most 320 pixels per side; `photos` have the size of their views.
std::vector<LabelledView> labelled_views(const LabelledObjects& objects, std::span<const View> photos);
inline constexpr int kLabelSide = 320;

struct SurfelLabels {
  std::vector<uint16_t> label;
  std::vector<uint8_t> seen;  // by at least one photo
};
// [surfels] `near_z`: of the rasteriser.
SurfelLabels labels_of_surfels(const SplatLayer& layer, float near_z, std::span<const LabelledView> views);
// [vertices]
std::vector<uint16_t> labels_of_vertices(const TriMesh& mesh, std::span<const LabelledView> views);
// [count] For positions behind or inside glass.
std::vector<uint16_t> labels_of_places(size_t count, const std::function<Vec3d(size_t)>& place,
                                       std::span<const LabelledView> views);

bool shows_thin_glass(const ObjectSet& objects, uint16_t label);
// Replaces the labels of thin glass by 0.
void leave_out_thin_glass(const ObjectSet& objects, std::span<uint16_t> labels);
// Sets the ids of all surfels: those of the diffuse layer from the photos, those of the transmittance layer from their positions.
void assign_objects(const ObjectSet& objects, std::span<const LabelledView> views, float near_z, SplatLayer& diffuse,
                    SplatLayer& transmittance);

// [h,w] The object with the largest blended weight in each pixel, 0 where the unassigned surfels and the background have more.
Image16 rendered_objects(const SplatLayer& diffuse, float near_z, const View& view);

}  // namespace vitrine
