// VGG feature network, forward and backward on oneDNN: 3x3 convolutions (padding 1) with ReLU, 2x2 maximum pooling between
// blocks. The features are the activations at the end of every block (VGG16: relu1_2, 2_2, 3_3, 4_3, 5_3).
//
// Weights are a safetensors file with float32 tensors `features.<i>.weight` [out, in, 3, 3] and `features.<i>.bias` [out],
// numbered like the layers of torchvision's VGG: i counts convolutions, ReLUs and poolings, so that an increment of 2 to the
// next convolution means the same block and an increment of 3 a pooling layer in between. Other tensors are not read.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace vitrine {

class FeatureNetwork {
 public:
  // Throws Error{Input} with the file name if it is missing, damaged, or not such a network.
  explicit FeatureNetwork(const std::filesystem::path& path);
  ~FeatureNetwork();

  // Output of forward() for backward(): every activation, channels last.
  struct Activations {
    std::vector<std::vector<float>> after_convolution;  // after its ReLU
    std::vector<float> input;
  };
  struct Feature {
    size_t convolution;  // index into Activations::after_convolution
    int width, height, channels;
  };

  // Prepares the network for pictures of this size; returns the features that have at least one pixel. Not thread-safe.
  std::span<const Feature> prepare(int width, int height);
  // `rgb`: [h, w, 3] in [0,1], of the prepared size. Thread-safe.
  void forward(std::span<const float> rgb, Activations& out) const;
  // `grad`: one vector per feature, shaped like its activation. Writes the gradient of `rgb`.
  void backward(const Activations& activations, std::span<const std::vector<float>> grad, std::span<float> grad_rgb) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Reader of float32 tensors from a safetensors file: 8 bytes length of the header (little endian), a JSON header {"name":
// {"dtype": "F32", "shape": [...], "data_offsets": [begin, end]}, ...}, then the bytes of the tensors.
struct Tensor {
  std::vector<size_t> shape;
  std::vector<float> values;
};
// Reads the tensors whose name starts with `prefix`. Throws Error{Input} with file and cause.
std::map<std::string, Tensor> read_safetensors(const std::filesystem::path& path, const std::string& prefix);

}  // namespace vitrine
