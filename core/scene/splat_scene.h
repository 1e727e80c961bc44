// What is optimised: the sets of surfels that an image model reads. A gradient of the scene has the same type.
#pragma once

#include "core/scene/layers.h"

namespace vitrine {

struct SplatScene {
  SplatLayer diffuse;
};

}  // namespace vitrine
