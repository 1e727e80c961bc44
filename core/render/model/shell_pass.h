// Reflections in curved sheets of clear glass: known shapes of role Sheet without flat facets (a dome, a bottle, any mesh). A
// flat pane shows a picture (PanePass); here rays are mirrored one by one, at the wall that the pixel's ray enters by and, where
// it gets past everything inside, at the wall that it leaves by:
//
//   near wall   mirrors what lies outside of it          far wall   mirrors what lies on its inner side
//
// The rays go through the scene without its glass (FramePart::OpenedScene); what lies beyond all of it is left to the reflection
// layer, as with panes (kernels/pane_blend.h). No gradient reaches what they meet: the scene is learnt where photos show it
// directly. Pixels of a group share the rays of the chosen one; whether and where a pixel looks out through the far wall is its
// own.
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
    return {.reads = {FramePart::DiffuseChannels, FramePart::Surfaces, FramePart::Sheets, FramePart::TransmissionAskers,
                      FramePart::OpenedScene, FramePart::BehindGlass},
            .adds = {FramePart::Panes, FramePart::ReflectionAskers}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene&, Frame&, SplatScene&) override {}

 private:
  struct Wall {
    Vec3d position, normal;          // outwards
    float cosine = 0;                // of the ray with the normal
    bool met = false, open = false;  // open: the pixel looks out through it, past everything inside
  };
  // The far wall of a pixel's shell.
  Wall far_wall(const Frame& frame, uint32_t pixel) const;
  void emit(const Frame& frame);
  void spread_to_groups(Frame& frame) const;

  std::unique_ptr<Tracer> tracer_;
  std::vector<Bounds3> shell_;  // [entry] bounds of a curved sheet; empty of other shapes
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
