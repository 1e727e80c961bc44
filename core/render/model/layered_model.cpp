#include "core/render/model/layered_model.h"

#include "core/render/model/composite_pass.h"
#include "core/render/model/diffuse_pass.h"
#include "core/render/model/display_pass.h"
#include "core/render/model/opaque_pass.h"
#include "core/render/model/pane_pass.h"
#include "core/render/model/reflection_pass.h"
#include "core/render/model/sheet_pass.h"
#include "core/render/model/shell_pass.h"
#include "core/render/model/silhouette_pass.h"
#include "core/render/model/surface_pass.h"
#include "core/render/model/thin_glass_pass.h"
#include "core/render/model/transmission_pass.h"

namespace vitrine {

LayeredModel::LayeredModel(const ImageOptions& options) : ImageModel(options) {
  const Backend backend = options.diffuse.backend;
  emplace<DiffusePass>(backend);
  emplace<SheetPass>();
  shape_ = emplace<ShapePass>();
  emplace<SilhouettePass>(backend);
  emplace<SurfacePass>();
  emplace<ThinGlassPass>(backend);
  emplace<PanePass>(backend);
  emplace<ShellPass>(options.reflection.backend);
  emplace<ReflectionPass>(options.reflection.backend);
  emplace<TransmissionPass>(options.transmission.backend);
  emplace<CompositePass>();
  emplace<SilhouetteBlendPass>();
  emplace<OpaquePass>(backend);
  emplace<DisplayPass>();
}

}  // namespace vitrine
