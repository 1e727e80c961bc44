// Planar reflections in flat glass panes and flat mirrors: the facets of known shapes of role Sheet (a box for a display case,
// a plane for a single pane) and of opaque flat shapes. The reflection equals the picture of a camera mirrored at the plane;
// for each pane the scene without glass is rasterised from that camera. A pixel uses two panes, the one through which its ray
// enters and, if the ray passes everything inside a closed case, the one through which it leaves:
//
//   near pane   reflects the scene outside the case      far pane   reflects the scene on its inner side
//
// (Further bounces, or the attenuation of the far reflection by the near pane, are worth 43 dB on the sample scene; the far
// pane 31, both 20.) Reflections show the room as the layers contain it: rooms seen directly in photos are learnt there, not
// from their faint reflection. Radiance beyond the scene (for example the sky) is left to the rays of the reflection layer.
// Flat mirrors, the facets of opaque known shapes, are rendered the same way, with a near pane only.
// The pass covers pixels that request transmission and look through thin glass first (SheetPass) or show a mirror (ShapePass).
// A flat mirror of known position acts as one more camera: gradients flow through its picture to the mirrored scene. Its own
// surfels, which training moves slightly in front of the plane, do not occlude the scene in it. No gradients flow through the
// faint reflections of panes. Without a facet the pass does nothing.
// without a facet.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/render/model/kernels/pane_blend.h"
#include "core/render/model/pass.h"
#include "core/render/model/picture_window.h"
#include "core/render/model/window_picture.h"

namespace vitrine {

// Fraction of the glass tolerance: surfels closer to a pane belong to its frame or floor and are not reflected in it.
inline constexpr double kAtPane_rel = 0.4;

// Camera mirrored at the plane dot(normal, p) = offset: its picture, flipped left to right, is the reflection that `view` sees.
View mirrored_view(const View& view, const Vec3d& normal, double offset);

class PanePass final : public Pass {
 public:
  // `backend`: of the rasteriser.
  explicit PanePass(Backend backend) : backend_(backend), window_picture_(backend) {}
  std::string_view name() const override { return "panes"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels, FramePart::Surfaces, FramePart::Sheets, FramePart::ShownShapes,
                      FramePart::TransmissionRequests, FramePart::BehindGlass},
            .writes = {FramePart::Panes},
            .adds = {FramePart::ReflectionRequests, FramePart::OpenedScene},
            .reverse_reads = {FramePart::ErrorImage},
            .reverse_adds = {FramePart::DiffuseStatistics, FramePart::TransmittanceStatistics}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  struct Pane {
    Facet plane;
    bool clear;
    double at_pane;  // kAtPane_rel, scene units
  };
  void find_own(const SplatScene& scene, const ShapeSet& set, float min_specular);
  void list_panes(const ShapeSet& set);
  uint32_t entry_of(uint32_t pane) const;
  void find_panes(const Frame& frame, PaneImages& out);
  void find_mirrors(const Frame& frame, PaneImages& out);
  // The panes through which a pixel's ray enters and leaves.
  enum Side : unsigned char { Near, Far };
  void mirror(const Frame& frame, uint32_t pane, Side side, PaneImages& out);

  // The reflection in a flat mirror, whose gradients reach the scene.
  struct MirrorPicture {
    uint32_t pane;
    PictureWindow window;
    std::vector<uint8_t> wanted;
    WindowPicture* picture;
  };

  Backend backend_;
  std::vector<Pane> panes_;                       // the facets of all shapes
  std::vector<uint32_t> first_pane_;              // [entry + 1]
  std::array<std::vector<uint32_t>, 2> pane_of_;  // [side] [h,w] index of panes_, or kNoPane
  std::vector<uint32_t> own_;                     // [diffuse surfel] 1 + entry of the flat mirror it represents; 0: none
  WindowPicture window_picture_;
  std::vector<uint8_t> wanted_;
  std::vector<MirrorPicture> mirrors_;
  std::vector<std::unique_ptr<WindowPicture>> pictures_;  // [mirror] reused between frames
  SplatLayer grad_;
  SurfelStatistics statistics_;
};

}  // namespace vitrine
