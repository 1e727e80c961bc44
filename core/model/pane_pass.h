// What the panes of a display case mirror. Where the case is known as a box, its panes are planes, and a picture in a flat mirror
// is the picture that a camera behind the mirror takes: the scene is rasterised from there, pane by pane, without the case. Two
// panes count in a pixel, the one that its ray enters by and, where it gets past everything inside, the one it leaves by:
//
//   near pane   mirrors what lies outside of it          far pane   mirrors what lies on its inner side
//
// (What a ray meets third, or what the near pane takes from the far one's picture, is worth 43 dB on the sample scene; the far
// pane 31, both 20.) A mirror shows the room as the layers have it: room that photos show directly is learnt there, not
// from its faint picture in a pane; what lies beyond all of it (a sky, above) is left to the rays of the reflection layer.
// Pixels take part that ask for a transmission and show the box where it is. No gradient goes through the mirrored pictures.
// Nothing to do without PaneOptions::glass_case or where ThinGlassPass, whose surfels are mirrored, had nothing to show.
#pragma once

#include <array>
#include <vector>

#include "core/model/kernels/pane_blend.h"
#include "core/model/pass.h"
#include "core/model/window_picture.h"

namespace vitrine {

// The camera behind a mirror: its picture, turned left to right, is what `view` sees in the plane dot(normal, p) = offset.
View mirrored_view(const View& view, const Vec3d& normal, double offset);

class PanePass final : public Pass {
 public:
  // `backend`: of the rasteriser.
  explicit PanePass(Backend backend) : window_picture_(backend) {}
  std::string_view name() const override { return "panes"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels, FramePart::Surfaces, FramePart::TransmissionAskers, FramePart::OpenedScene,
                      FramePart::BehindGlass},
            .writes = {FramePart::Panes},
            .adds = {FramePart::ReflectionAskers}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene&, Frame&, SplatScene&) override {}

 private:
  void find_panes(const Frame& frame, PaneImages& out);
  // The two panes that a pixel's ray passes.
  enum Pane : unsigned char { Near, Far };
  void mirror(const Frame& frame, Box::Face face, Pane pane, PaneImages& out);

  WindowPicture window_picture_;
  std::array<std::vector<uint8_t>, 2> face_of_;  // [pane] [h,w] Box::Face::index, kNoFace
  std::vector<uint8_t> wanted_;
};

}  // namespace vitrine
