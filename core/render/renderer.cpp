#include "core/render/renderer.h"

#include "core/render/cpu/cpu_renderer.h"
#include "core/render/reference/reference_renderer.h"

namespace vitrine {

std::unique_ptr<Renderer> make_renderer(Backend backend, Simd simd) {
  return backend == Backend::Reference ? make_reference_renderer() : make_cpu_renderer(simd);
}

}  // namespace vitrine
