// A network that looks at one photo and answers with a picture, run on the processor by OpenCV's dnn module (README.md): checked
// before it is loaded, fed as declared, its answer checked before anyone reads it. No OpenCV header leaves photo_network.cpp.
#pragma once

#include <functional>
#include <memory>
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

  // Size at which a photo of width x height goes in.
  std::pair<int, int> size_of(int photo_width, int photo_height) const;
  // What contradicts itself, in words that begin with `prefix` ("onnx."); empty when nothing does.
  std::string problem(const std::string& prefix) const;
};
// Inside the describe() of the options that hold it: no group of its own.
void describe_input(Describer& d, NetworkInput& c);

struct PhotoNetworkDesc {
  std::string where;  // the file, for messages
  NetworkInput input;
  std::string options;     // where its options stand: "normals.onnx"
  std::string instead;     // what to do when OpenCV cannot run it: "use normals.source=files"
  std::string unlike;      // message for an answer of another shape: "the network's output is no picture of normals" ...
  std::string shape_hint;  // ... and its advice
  std::function<bool(int channels)> fits;  // numbers of channels that the answer may have
};

// A picture of `channels` numbers a pixel.
struct NetworkOutput {
  int channels = 0, width = 0, height = 0;
  bool planes = true;  // [c,h,w]; else [h,w,c]
  std::vector<float> values{};
  std::string shape{};  // as the network told it: "1 x 3 x 48 x 64"

  size_t pixel_count() const { return size_t(width) * size_t(height); }
  float at(size_t pixel, int channel) const {
    return values[planes ? size_t(channel) * pixel_count() + pixel : size_t(channels) * pixel + size_t(channel)];
  }
};

class PhotoNetwork {
 public:
  // `bytes` of an ONNX file. Throws Error{Input}: another digest than input.sha256, not ONNX, an operator that OpenCV does not
  // compute rightly, a graph that it cannot take in.
  PhotoNetwork(std::string_view bytes, PhotoNetworkDesc desc);
  ~PhotoNetwork();

  // `srgb`: display-referred, of the size that input.size_of() says. Throws Error{Input} when the network cannot be run on it or
  // its answer is of another shape than declared.
  NetworkOutput run(const ImageF& srgb);
  const std::string& sha256() const;
  const PhotoNetworkDesc& desc() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vitrine
