// Stage `normals`: surface normals of every photo's pixels, with a confidence, as a target for training (README.md).
//   reads   sfm (cameras, sparse points, undistorted photos); optionally normal maps or a network of the user
//   writes  normals/<stem>.exr (X Y Z, OpenCV camera frame; 0 0 0 = unknown), normals/<stem>_confidence.png, normals/report.json
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/observe/network/photo_network.h"
#include "core/scene/image/image.h"
#include "stages/normals/normal_map.h"
#include "stages/stage.h"

namespace vitrine {

enum class NormalSource { Auto, Files, Onnx, Geometric, None };
inline constexpr std::array<std::string_view, 5> kNormalSourceWords{"auto", "files", "onnx", "geometric", "none"};
enum class NormalEncoding { Vector, Rgb };     // of a network's output; Rgb: (n + 1) / 2
enum class NormalDoubt { Smoothness, Kappa };  // what the confidence of a network's normals comes from

struct GeometricConfig {
  int max_side = 240;
};
void describe(Describer& d, GeometricConfig& c);

struct NormalFilesConfig {
  std::string space = "auto";
};
void describe(Describer& d, NormalFilesConfig& c);

struct OnnxConfig {
  std::string space = "auto";
  NetworkInput input{};
  NormalEncoding output = NormalEncoding::Vector;
  NormalDoubt doubt = NormalDoubt::Smoothness;
};
void describe(Describer& d, OnnxConfig& c);

struct NormalsConfig {
  NormalSource source = NormalSource::Auto;
  int max_side = 480;
  int holdout_every = 8;
  GeometricConfig geometric;
  NormalFilesConfig files;
  OnnxConfig onnx;
};
void describe(Describer& d, NormalsConfig& c);

void run_normals(const NormalsConfig& config, StageContext& context);
Stage normals_stage();
StageCost normals_cost(const CostTerms& terms);
StageReport normals_report();

// Normal prediction from one photo by a network (core/observe/network): the user's or the built-in one.

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
