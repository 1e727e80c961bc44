// Equirectangular pictures of a trained scene. The renderer is one of pinholes: six faces of a cube, each a little wider than 90
// degrees, are rendered and looked up per direction (bilinear, linear light). Where faces overlap their weights fall to 0 at the
// border of each, so that no seam remains.
#pragma once

#include "core/render/picture/view_picture.h"

namespace vitrine {

// The upright camera at the centre of `view`: heading of `view` in the middle of the picture, +z of the world up. Looking along
// the vertical, the heading is that of the top of the picture.
View upright_panorama(const View& view);

// Width of a panorama with as many pixels per radian as `k` has in its middle; a multiple of 4.
int panorama_width(const Intrinsics& k);

// Intrinsics as rendered picture: width x width / 2. `view`: of `upright_panorama`; its intrinsics are not used. Layers as for
// pinhole pictures, but depth is the distance from the centre. ViewPicture::zdepth is that distance, too.
ViewPicture panorama_picture(ScenePainter& painter, const View& view, int width);

}  // namespace vitrine
