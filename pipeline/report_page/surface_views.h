// Ray-cast pictures of the mesh from the cameras of the photos: shaded grey, and normals.
#pragma once

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/mesh/mesh_hits.h"

namespace vitrine {

struct SurfaceView {
  Image8 clay;     // lit from the camera, slightly from above
  Image8 normals;  // in the camera's frame: red right, green up, blue towards the camera
};

SurfaceView surface_view(const MeshHits& mesh, const View& view, int max_side);

}  // namespace vitrine
