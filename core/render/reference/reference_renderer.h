// Renderer "reference": double, O(pixels x surfels). For tests, benchmarks' checks and for bisecting a wrong picture.
#pragma once

#include <memory>

#include "core/render/renderer.h"

namespace vitrine {

std::unique_ptr<Renderer> make_reference_renderer();

}  // namespace vitrine
