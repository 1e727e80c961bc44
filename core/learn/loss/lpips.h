// LPIPS (Zhang et al. 2018, version 0.1 with VGG16): the perceptual distance of two pictures,
//   d = sum_t 1/P_t sum_p sum_c w_tc (f_t(x)_pc - f_t(y)_pc)^2,   f = features / (|features| + 1e-10) over the channels of a
//   pixel
// of the features of feature_network.h and the learned weights w_t of their channels. Weights belong to the user: one safetensors
// file with the tensors of the network and `lin<t>.model.1.weight` [1, channels, 1, 1] (README).
#pragma once

#include <filesystem>
#include <vector>

#include "core/learn/loss/feature_network.h"
#include "core/scene/image/image.h"

namespace vitrine {

class Lpips {
 public:
  // Throws Error{Input} if the file is missing, damaged, or lacks one of the tensors.
  explicit Lpips(const std::filesystem::path& weights);
  // Of two sRGB pictures of one size, [h, w, 3] in [0, 1]. 0: equal. Runs on one thread, two for the two pictures.
  double distance(const ImageF& srgb, const ImageF& reference);

 private:
  FeatureNetwork network_;
  std::vector<std::vector<float>> channel_weights_;  // [features][channels]
};

}  // namespace vitrine
