#include "core/render/raster/renderer.h"

namespace vitrine {

std::unique_ptr<Renderer> make_cpu_renderer(Simd simd);
std::unique_ptr<Renderer> make_reference_renderer();

std::unique_ptr<Renderer> make_renderer(Backend backend, Simd simd) {
  return backend == Backend::Reference ? make_reference_renderer() : make_cpu_renderer(simd);
}

}  // namespace vitrine
