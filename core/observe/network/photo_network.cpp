#include "core/observe/network/photo_network.h"

#include <algorithm>
#include <cmath>

#include <opencv2/dnn.hpp>

#include "core/foundation/base/error.h"
#include "core/foundation/base/hash.h"
#include "core/foundation/config/describe.h"

namespace vitrine {

namespace {

constexpr int kSmallestAnswer = 8;  // pixels on a side: a smaller output is a feature vector, not a picture

}  // namespace

std::pair<int, int> NetworkInput::size_of(int photo_width, int photo_height) const {
  if (width > 0) return {width, height};
  const double scale = double(max_side) / std::max(photo_width, photo_height);
  const auto rounded = [&](int side) { return std::max(1, int(std::lround(scale * side / multiple))) * multiple; };
  return {rounded(photo_width), rounded(photo_height)};
}

std::string NetworkInput::problem(const std::string& prefix) const {
  if (mean.size() != 3 || deviation.size() != 3) return prefix + "mean and " + prefix + "deviation take three numbers each";
  for (double d : deviation)
    if (!(d > 0)) return prefix + "deviation must be positive";
  if ((width == 0) != (height == 0)) return prefix + "width and " + prefix + "height are given together, or neither";
  return {};
}

void describe_input(Describer& d, NetworkInput& c) {
  d.option("width", c.width, "Width of the network's input; 0 = from max_side.").range(0, 8192);
  d.option("height", c.height, "Height of the network's input; 0 = from max_side.").range(0, 8192);
  d.option("max_side", c.max_side, "Longest side of its input, when its size is free.").range(16, 8192);
  d.option("multiple", c.multiple, "Both sides of its input are a multiple of this, when its size is free.").range(1, 1024);
  d.choice("layout", c.layout, {"nchw", "nhwc"}, "Order of its input: planes of channels, or channels of pixels.");
  d.choice("channels", c.channels, {"rgb", "bgr"}, "Order of the channels.");
  d.option("mean", c.mean, "Subtracted from the photo, sRGB in [0,1], per channel.");
  d.option("deviation", c.deviation, "What that is divided by, per channel.");
  d.option("sha256", c.sha256, "SHA-256 that the network's file must have; empty = any.");
}

struct PhotoNetwork::State {
  PhotoNetworkDesc desc;
  std::string digest;
  cv::dnn::Net net;

  [[noreturn]] void refuse(const std::string& what, const std::string& why, const std::string& hint, const char* code) const {
    throw Error(ErrorKind::Input, what, {.where = desc.where, .why = why, .hint = hint, .code = code});
  }
};

PhotoNetwork::PhotoNetwork(std::string_view bytes, PhotoNetworkDesc desc) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.desc = std::move(desc);
  s.digest = sha256_hex(bytes);
  if (const std::string& expected = s.desc.input.sha256; !expected.empty() && expected != s.digest)
    s.refuse("the network is not the one that is expected", fmt::format("SHA-256 {} instead of {}", s.digest, expected),
             fmt::format("fetch it again, or correct {}.sha256", s.desc.options), "WRONG_DIGEST");
  const std::vector<std::string> missing = unsupported_operators(onnx_operators(bytes, s.desc.where));
  if (!missing.empty())
    s.refuse("the network uses operators that OpenCV 4.6 does not compute rightly", fmt::format("{}", fmt::join(missing, ", ")),
             fmt::format("convolutional networks work, transformers do not; run it in its own program and {}", s.desc.instead),
             "UNSUPPORTED_OPERATOR");
  try {
    s.net = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
    s.net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  } catch (const cv::Exception& e) {
    s.refuse("OpenCV cannot take this network in", e.err,
             "export it again with opset 12 and constant folding; core/observe/network/README.md lists what works",
             "UNSUPPORTED_NETWORK");
  }
}

PhotoNetwork::~PhotoNetwork() = default;
const std::string& PhotoNetwork::sha256() const { return state_->digest; }
const PhotoNetworkDesc& PhotoNetwork::desc() const { return state_->desc; }

NetworkOutput PhotoNetwork::run(const ImageF& srgb) {
  State& s = *state_;
  const NetworkInput& c = s.desc.input;
  const int w = srgb.width(), h = srgb.height();
  const bool planes_first = c.layout == TensorLayout::Nchw;
  const int nchw[] = {1, 3, h, w}, nhwc[] = {1, h, w, 3};
  cv::Mat blob(4, planes_first ? nchw : nhwc, CV_32F);
  float* in = blob.ptr<float>();
  const size_t pixels = size_t(w) * size_t(h);
  for (size_t i = 0; i < pixels; ++i)
    for (size_t channel = 0; channel < 3; ++channel) {
      const size_t source = c.channels == ChannelOrder::Bgr ? 2 - channel : channel;
      const float value = (srgb.data()[3 * i + source] - float(c.mean[channel])) / float(c.deviation[channel]);
      in[planes_first ? channel * pixels + i : 3 * i + channel] = value;
    }
  cv::Mat answer;
  try {
    s.net.setInput(blob);
    answer = s.net.forward();
  } catch (const cv::Exception& e) {
    s.refuse("the network cannot be run on a photo", fmt::format("input of {} x {}: {}", w, h, e.err),
             fmt::format("its input size and layout go to {}.width, height, layout", s.desc.options), "NETWORK_FAILED");
  }
  std::vector<int> shape(answer.size.p, answer.size.p + answer.dims);
  NetworkOutput out{.shape = fmt::format("{}", fmt::join(shape, " x "))};
  while (shape.size() > 3 && shape.front() == 1) shape.erase(shape.begin());
  if (shape.size() == 2) shape.insert(shape.begin(), 1);
  out.planes = shape.size() == 3 && s.desc.fits(shape[0]) && (planes_first || !s.desc.fits(shape[2]));
  if (shape.size() != 3 || answer.depth() != CV_32F || !(out.planes || s.desc.fits(shape[2])))
    s.refuse(s.desc.unlike, fmt::format("its shape is {}", out.shape), s.desc.shape_hint, "BAD_NETWORK_OUTPUT");
  out.channels = out.planes ? shape[0] : shape[2];
  out.height = out.planes ? shape[1] : shape[0];
  out.width = out.planes ? shape[2] : shape[1];
  // Networks for other tasks, or with a feature vector as output, have another shape.
  if (std::abs(double(out.width) * h - double(out.height) * w) > 2.0 * std::max(w, h) ||
      std::min(out.width, out.height) < kSmallestAnswer)
    s.refuse("the network's output does not have the photo's shape",
             fmt::format("{} x {} for a photo of {} x {}", out.width, out.height, w, h),
             fmt::format("{}.width and height must be what it was trained for", s.desc.options), "BAD_NETWORK_OUTPUT");
  const float* first = answer.ptr<float>();
  out.values.assign(first, first + answer.total());
  return out;
}

}  // namespace vitrine
