#include "core/render/model/layered_model.h"

#include <array>

#include "core/foundation/base/error.h"
#include "core/render/model/composite_pass.h"
#include "core/render/model/opaque_pass.h"
#include "core/render/model/pane_pass.h"
#include "core/render/model/sheet_pass.h"
#include "core/render/model/shell_pass.h"
#include "core/render/model/silhouette_pass.h"
#include "core/render/model/surface_pass.h"
#include "core/render/model/thin_glass_pass.h"
#include "core/render/model/traced_passes.h"

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
  medium_ = emplace<MediumPass>();
  emplace<DisplayPass>();
}

namespace {

constexpr std::array<std::string_view, kFrameParts> kPartNames{"diffuse channels",
                                                               "linear radiance",
                                                               "shown shapes",
                                                               "coats",
                                                               "silhouettes",
                                                               "sheets",
                                                               "surfaces",
                                                               "reflection requests",
                                                               "transmission requests",
                                                               "opened scene",
                                                               "behind glass",
                                                               "panes",
                                                               "reflected radiance",
                                                               "transmitted radiance",
                                                               "picture weights",
                                                               "layer images",
                                                               "clear radiance",
                                                               "display picture",
                                                               "error image",
                                                               "diffuse sums",
                                                               "reflection sums",
                                                               "transmittance sums"};
static_assert(!kPartNames.back().empty());

[[noreturn]] void refuse(std::string_view pass, std::string_view does, FramePart part, const std::string& why) {
  throw Error(ErrorKind::Internal, fmt::format("pass '{}' {} '{}'{}", pass, does, name(part), why),
              {.hint = "change the order in which the passes are added to the model", .code = "PASS_ORDER"});
}

}  // namespace

std::string_view name(FramePart part) { return kPartNames[static_cast<size_t>(part)]; }

void start_statistics(const SplatScene& scene, Frame& frame) {
  frame.statistics.reset(scene.diffuse.size());
  frame.reflection.statistics.reset(scene.reflection.size());
  frame.transmission.statistics.reset(scene.transmittance.size());
  frame.reflection.took_part = frame.transmission.took_part = false;
}

void ImageModel::add(std::unique_ptr<Pass> pass) {
  writer_.resize(kPartNames.size()), reader_.resize(kPartNames.size());
  const auto of = [](std::vector<std::string>& passes, FramePart part) -> std::string& {
    return passes[static_cast<size_t>(part)];
  };
  const PassAccess access = pass->access();
  for (const FramePart part : access.reads)
    if (of(writer_, part).empty()) refuse(pass->name(), "reads", part, ", which no pass before it writes");
  for (const FramePart part : access.adds) {
    if (of(writer_, part).empty()) refuse(pass->name(), "adds to", part, ", which no pass before it writes");
    if (!of(reader_, part).empty())
      refuse(pass->name(), "adds to", part, fmt::format(", which pass '{}' before it has read", of(reader_, part)));
  }
  for (const FramePart part : access.writes) {
    if (!of(writer_, part).empty()) refuse(pass->name(), "writes", part, fmt::format(" as pass '{}' does", of(writer_, part)));
    of(writer_, part) = pass->name();
  }
  for (const FramePart part : access.reads)
    if (of(reader_, part).empty()) of(reader_, part) = pass->name();
  passes_.push_back(std::move(pass));
}

void ImageModel::forward(const SplatScene& scene, const View& view, const ImageOptions& options, Frame& frame) const {
  frame.view = &view;
  frame.options = options;
  for (const auto& pass : passes_) pass->forward(scene, frame);
}

void ImageModel::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) const {
  start_statistics(scene, frame);
  for (auto pass = passes_.rbegin(); pass != passes_.rend(); ++pass) (*pass)->backward(scene, frame, grad);
}

}  // namespace vitrine
