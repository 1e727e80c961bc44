// Traced reflections in curved thin glass: known shapes of role Sheet without flat facets (a dome, a bottle, any mesh). Flat
// panes use a rasterised picture (PanePass); here each ray is reflected individually, at the glass wall where the pixel's ray
// enters and, if it passes everything inside, at the wall where it leaves:
//
//   near wall   reflects the scene outside               far wall   reflects the scene on its inner side
//
// The rays pass through the scene without glass (FramePart::OpenedScene); radiance beyond it is left to the reflection layer,
// as for panes (kernels/pane_blend.h). The hit surfels receive no gradient: photos that show them directly train them. Pixels
// of a group share the rays of the chosen pixel; the exit point at the far wall is computed per pixel.
#pragma once

#include <memory>
#include <vector>

#include "core/render/model/pass.h"

namespace vitrine {

class ShellPass final : public Pass {
 public:
  explicit ShellPass(TracerBackend backend) : tracer_(make_tracer(backend)) {}
  std::string_view name() const override { return "shells"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels, FramePart::Surfaces, FramePart::Sheets, FramePart::TransmissionRequests,
                      FramePart::OpenedScene, FramePart::BehindGlass},
            .adds = {FramePart::Panes, FramePart::ReflectionRequests}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene&, Frame&, SplatScene&) override {}

 private:
  struct Wall {
    Vec3d position, normal;          // outwards
    float cosine = 0;                // of the ray with the normal
    bool met = false, open = false;  // open: the ray leaves through it, past everything inside
  };
  // The far glass wall of a pixel's ray.
  Wall far_wall(const Frame& frame, uint32_t pixel) const;
  void emit(const Frame& frame);
  void spread_to_groups(Frame& frame) const;

  std::unique_ptr<Tracer> tracer_;
  std::vector<Bounds3> shell_;  // [entry] bounds of curved thin glass; empty for other shapes
  struct Mirrored {
    uint32_t group;
    bool far;
  };
  std::vector<Mirrored> mirrored_;
  std::vector<Vec3f> origins_, directions_;
  std::vector<float> near_;
  RayValues values_;
};

}  // namespace vitrine
