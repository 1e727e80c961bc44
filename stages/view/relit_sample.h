// One relit picture beside the page, with which the report opens: the first held-out view under the light of the photos, turned
// about the vertical, so that shadows and mirrors show another light.
#pragma once

#include <string>

#include "core/camera/view.h"
#include "core/relight/relit_scene.h"

namespace vitrine {

// A JPEG at the size of the view; the same for any number of threads.
std::string relit_sample(const RelitScene& scene, const View& view);

}  // namespace vitrine
