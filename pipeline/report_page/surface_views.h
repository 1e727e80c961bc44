// The mesh as the photos' cameras see it: clay and normals, by casting rays.
#pragma once

#include "core/camera/view.h"
#include "core/image/image.h"
#include "core/trace/mesh_hits.h"

namespace vitrine {

struct SurfaceView {
  Image8 clay;     // lit from the camera and a little from above
  Image8 normals;  // in the camera's frame: red right, green up, blue towards the camera
};

SurfaceView surface_view(const MeshHits& mesh, const View& view, int max_side);

}  // namespace vitrine
