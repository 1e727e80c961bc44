// Normal prediction from one photo by a network (core/observe/network): the user's or the built-in one.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "core/scene/image/image.h"
#include "stages/normals/normal_map.h"
#include "stages/normals/normals.h"

namespace vitrine {

class NormalNetwork {
 public:
  // Loads the file, or the built-in network without one. Throws Error{Input}: unreadable, not ONNX, digest differs from
  // config.sha256, an operator missing in OpenCV, or an output that is not an image of normals.
  NormalNetwork(const std::optional<std::filesystem::path>& file, const OnnxConfig& config);
  ~NormalNetwork();

  // Network input size for a photo of width x height.
  std::pair<int, int> input_size(int width, int height) const;
  // `srgb` has that size. Returns normals in the network's frame, at its output size.
  NormalMap predict(const ImageF& srgb);
  const std::string& sha256() const;
  bool built_in() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Digest of the built-in network, for the cache key.
std::string built_in_network_sha256();
// Input and output of the built-in network.
OnnxConfig built_in_network_config();

}  // namespace vitrine
