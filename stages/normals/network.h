// A network that predicts normals from one photo (core/observe/network), and the one that is built in.
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
  // The file, else the network that is built in. Throws Error{Input}: unreadable, not ONNX, another digest than config.sha256, an
  // operator that OpenCV lacks, an output that is no picture of normals.
  NormalNetwork(const std::optional<std::filesystem::path>& file, const OnnxConfig& config);
  ~NormalNetwork();

  // Size at which a photo of width x height goes in.
  std::pair<int, int> input_size(int width, int height) const;
  // `srgb` has that size. Normals in the network's own frame, at the size it gives.
  NormalMap predict(const ImageF& srgb);
  const std::string& sha256() const;
  bool built_in() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The digest of the network that is built in, for the cache key.
std::string built_in_network_sha256();
// Input and output of the network that is built in.
OnnxConfig built_in_network_config();

}  // namespace vitrine
