// Water or haze between the camera and the surfaces (kernels/medium.h), with the mean ray distance of each pixel,
//   z = |ray| Z / A     Z = sum of w z-depth, A = sum of w (channels of the diffuse pass, known glass and shapes included)
// Runs on the composed picture, so that reflected and transmitted rays cross no medium beyond the first surface. Frame::clear
// keeps the picture without it. Without ImageOptions::medium the pass does nothing.
#pragma once

#include "core/render/model/pass.h"

namespace vitrine {

class MediumPass final : public Pass {
 public:
  std::string_view name() const override { return "medium"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels}, .writes = {FramePart::Clear}, .adds = {FramePart::Linear}};
  }
  void forward(const SplatScene& scene, Frame& frame) override;
  // Also to the channels ZDepth and Alpha, and to gradient().
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;
  // Of the last backward(); zero if its picture had no medium.
  const MediumCoefficients<double>& gradient() const { return gradient_; }

 private:
  MediumCoefficients<double> gradient_;
};

}  // namespace vitrine
