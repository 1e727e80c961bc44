#include "core/model/layered_model.h"

#include "core/model/display_pass.h"

namespace vitrine {

namespace {
template <class P, class... Options>
P* append(ImageModel& model, const Options&... options) {
  auto pass = std::make_unique<P>(options...);
  P* const raw = pass.get();
  model.add(std::move(pass));
  return raw;
}
}  // namespace

LayeredModel::LayeredModel(const ImageOptions& options)
    : diffuse(append<DiffusePass>(*this, options.diffuse)),
      shape(append<ShapePass>(*this, options.shape)),
      outline(append<OutlinePass>(*this, options.shape, options.diffuse)),
      surface(append<SurfacePass>(*this, options.surface)),
      thin_glass(append<ThinGlassPass>(*this, options.transmission, options.diffuse)),
      panes(append<PanePass>(*this, options.panes, options.diffuse.backend, *thin_glass)),
      reflection(append<ReflectionPass>(*this, options.reflection)),
      transmission(append<TransmissionPass>(*this, options.transmission)),
      composite(append<CompositePass>(*this, options.composite)) {
  append<OutlineBlendPass>(*this);
  append<DisplayPass>(*this);
}

}  // namespace vitrine
