// The relit picture at the top of the report, stored next to the page: the first held-out view under the light of the photos,
// rotated about the vertical, so that shadows and reflections differ.
#pragma once

#include <string>

#include "core/scene/camera/view.h"
#include "core/render/relight/relit_scene.h"

namespace vitrine {

// JPEG at the size of the view; the same for any number of threads.
std::string relit_sample(const RelitScene& scene, const View& view);

}  // namespace vitrine
