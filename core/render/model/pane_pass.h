// Reflections in flat panes of clear glass, the facets of known shapes of role Sheet, a display case (a box) or a single pane (a
// plane), and in flat mirrors. A picture in a flat mirror is the picture that a camera behind the mirror takes: the scene is
// rasterised from there, pane by pane, without the glass. Two panes count in a pixel, the one that its ray enters by and, where
// it gets past everything inside a closed sheet, the one it leaves by:
//
//   near pane   mirrors what lies outside of it          far pane   mirrors what lies on its inner side
//
// (What a ray meets third, or what the near pane takes from the far one's picture, is worth 43 dB on the sample scene; the far
// pane 31, both 20.) A mirror shows the room as the layers have it: room that photos show directly is learnt there, not
// from its faint picture in a pane; what lies beyond all of it (a sky, above) is left to the rays of the reflection layer.
// Flat mirrors, the facets of known shapes that are opaque, show the scene the same way, with a near pane alone.
// Pixels take part that ask for a transmission and look through a sheet first (SheetPass), or show a mirror (ShapePass). A flat
// mirror of known place is one more camera: gradients go through its picture to what it shows, and its own surfels, which
// training moves a little before it, do not hide the scene from it. None go through the faint pictures in panes. Nothing to do
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

// Of the tolerance of a sheet: what stands nearer to a pane is its frame or its floor, and not seen in it.
inline constexpr double kAtPane_rel = 0.4;

// The camera behind a mirror: its picture, turned left to right, is what `view` sees in the plane dot(normal, p) = offset.
View mirrored_view(const View& view, const Vec3d& normal, double offset);

class PanePass final : public Pass {
 public:
  // `backend`: of the rasteriser.
  explicit PanePass(Backend backend) : backend_(backend), window_picture_(backend) {}
  std::string_view name() const override { return "panes"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels, FramePart::Surfaces, FramePart::Sheets, FramePart::ShownShapes,
                      FramePart::TransmissionAskers, FramePart::BehindGlass},
            .writes = {FramePart::Panes},
            .adds = {FramePart::ReflectionAskers, FramePart::OpenedScene},
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
  void find_own(const SplatScene& scene, const ShapeSet& set, float polished);
  void list_panes(const ShapeSet& set);
  uint32_t entry_of(uint32_t pane) const;
  void find_panes(const Frame& frame, PaneImages& out);
  void find_mirrors(const Frame& frame, PaneImages& out);
  // The two panes that a pixel's ray passes.
  enum Side : unsigned char { Near, Far };
  void mirror(const Frame& frame, uint32_t pane, Side side, PaneImages& out);

  // The picture in a flat mirror, whose gradients reach the scene.
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
  std::vector<uint32_t> own_;                     // [diffuse surfel] 1 + entry of the flat mirror that it shows; 0: none
  WindowPicture window_picture_;
  std::vector<uint8_t> wanted_;
  std::vector<MirrorPicture> mirrors_;
  std::vector<std::unique_ptr<WindowPicture>> pictures_;  // [mirror] kept from frame to frame
  SplatLayer grad_;
  SurfelStatistics statistics_;
};

}  // namespace vitrine
