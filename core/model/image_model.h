// The image formation: an ordered list of passes, run forwards for a picture and backwards for gradients.
#pragma once

#include <memory>
#include <vector>

#include "core/model/diffuse_pass.h"
#include "core/model/pass.h"

namespace vitrine {

class ImageModel {
 public:
  void add(std::unique_ptr<Pass> pass) { passes_.push_back(std::move(pass)); }
  void forward(const SplatScene& scene, const View& view, Frame& frame) const {
    frame.view = &view;
    for (const auto& pass : passes_) pass->forward(scene, frame);
  }
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) const {
    for (auto pass = passes_.rbegin(); pass != passes_.rend(); ++pass) (*pass)->backward(scene, frame, grad);
  }

 private:
  std::vector<std::unique_ptr<Pass>> passes_;
};

}  // namespace vitrine
