// Runs a network on one photo on the CPU with OpenCV's dnn module (README.md). The graph is checked before loading and the
// output shape after each run. No OpenCV header is included outside photo_network.cpp.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/scene/image/image.h"

namespace vitrine {

class Describer;

enum class TensorLayout { Nchw, Nhwc };  // planes of channels, channels of pixels
enum class ChannelOrder { Rgb, Bgr };

// What goes into the network: the size, and which number of which colour stands where. Every stage with such a network declares
// these options among its own.
struct NetworkInput {
  int width = 0, height = 0;
  int max_side = 384;
  int multiple = 32;
  TensorLayout layout = TensorLayout::Nchw;
  ChannelOrder channels = ChannelOrder::Rgb;
  std::vector<double> mean{0, 0, 0};
  std::vector<double> deviation{1, 1, 1};
  std::string sha256 = "";

  // Network input size for a photo of width x height.
  std::pair<int, int> size_of(int photo_width, int photo_height) const;
  // Message about contradictory options, starting with `prefix` ("onnx."); empty when there are none.
  std::string problem(const std::string& prefix) const;
};
// Call inside the describe() of the enclosing options; adds no group of its own.
void describe_input(Describer& d, NetworkInput& c);

struct PhotoNetworkDesc {
  std::string where;  // the file, for messages
  NetworkInput input;
  std::string options;     // option group of the network: "normals.onnx"
  std::string instead;     // what to do when OpenCV cannot run it: "use normals.source=files"
  std::string unlike;      // message for an output of the wrong shape: "the network's output is no picture of normals" ...
  std::string shape_hint;  // ... and its hint
  std::function<bool(int channels)> fits;  // accepts this number of output channels
};

// Network output with `channels` values per pixel.
struct NetworkOutput {
  int channels = 0, width = 0, height = 0;
  bool planes = true;  // [c,h,w]; else [h,w,c]
  std::vector<float> values{};
  std::string shape{};  // shape of the output tensor: "1 x 3 x 48 x 64"

  size_t pixel_count() const { return size_t(width) * size_t(height); }
  float at(size_t pixel, int channel) const {
    return values[planes ? size_t(channel) * pixel_count() + pixel : size_t(channels) * pixel + size_t(channel)];
  }
};

class PhotoNetwork {
 public:
  // `bytes`: content of an ONNX file. Throws Error{Input}: the digest differs from input.sha256, not ONNX, an unsupported
  // operator, a graph that OpenCV cannot load.
  PhotoNetwork(std::string_view bytes, PhotoNetworkDesc desc);
  ~PhotoNetwork();

  // `srgb`: display-referred, of the size input.size_of() returns. Throws Error{Input} when the network fails or its output
  // shape differs from the declared one.
  NetworkOutput run(const ImageF& srgb);
  const std::string& sha256() const;
  const PhotoNetworkDesc& desc() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Reads the operators of an ONNX graph without running it. OpenCV's importer crashes on some operators and computes others
// wrongly without an error, so only networks whose operators are all known to be correct are accepted.

// Throws Error{Input} naming `where` when the bytes are not a complete ONNX model with a graph.
std::set<std::string> onnx_operators(std::string_view model, const std::string& where);
// The operators that OpenCV 4.6 does not support or computes wrongly.
std::vector<std::string> unsupported_operators(const std::set<std::string>& operators);

}  // namespace vitrine
