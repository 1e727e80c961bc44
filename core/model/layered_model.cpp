#include "core/model/layered_model.h"

#include "core/model/composite_pass.h"
#include "core/model/diffuse_pass.h"
#include "core/model/display_pass.h"
#include "core/model/opaque_pass.h"
#include "core/model/pane_pass.h"
#include "core/model/reflection_pass.h"
#include "core/model/sheet_pass.h"
#include "core/model/shell_pass.h"
#include "core/model/silhouette_pass.h"
#include "core/model/surface_pass.h"
#include "core/model/thin_glass_pass.h"
#include "core/model/transmission_pass.h"

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
