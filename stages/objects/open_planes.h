// Detection of rectangles in the masks of a class: windows, pictures under glass, mirrors on walls.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"
#include "core/scene/shape/shape_set.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// Role Sheet for glass, Mirror otherwise. `one_sided`: only rectangles that no photo sees from behind.
ShapeSet open_planes(MaskClass kind, std::span<const Silhouette> silhouettes, std::span<const ScenePoint> points, bool one_sided);

// The silhouettes, with the pixels of the shapes set to unknown.
std::vector<Silhouette> unexplained(std::span<const Silhouette> silhouettes, const ShapeSet& found);

}  // namespace vitrine
