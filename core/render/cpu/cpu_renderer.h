// Renderer "cpu": tiles, SIMD, threads (README 6-8).
#pragma once

#include <memory>

#include "core/render/renderer.h"

namespace vitrine {

std::unique_ptr<Renderer> make_cpu_renderer(Simd simd);

}  // namespace vitrine
