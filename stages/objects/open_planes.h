// Rectangles that the masks of a class show: windows, pictures under glass, mirrors on walls.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"
#include "core/scene/shape/shape_set.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// Of role Sheet for glass, Mirror for the rest. `one_sided`: only those that no photo sees from behind.
ShapeSet open_planes(MaskClass kind, std::span<const Silhouette> silhouettes, std::span<const ScenePoint> points, bool one_sided);

// Silhouettes in which the pixels that the shapes explain are unknown.
std::vector<Silhouette> unexplained(std::span<const Silhouette> silhouettes, const ShapeSet& found);

}  // namespace vitrine
