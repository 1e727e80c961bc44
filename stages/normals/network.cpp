#include "stages/normals/network.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/dnn.hpp>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/sha256.h"
#include "stages/normals/onnx_graph.h"

// The file itself, as the compiler's assembler takes it in; the build names it.
asm(".section .rodata\n"
    ".global vitrine_rooms_onnx\n"
    ".global vitrine_rooms_onnx_end\n"
    ".balign 16\n"
    "vitrine_rooms_onnx:\n"
    ".incbin \"" VITRINE_ROOMS_ONNX
    "\"\n"
    "vitrine_rooms_onnx_end:\n"
    ".byte 0\n"
    ".text\n");
extern "C" const char vitrine_rooms_onnx[], vitrine_rooms_onnx_end[];

namespace vitrine {

namespace {

constexpr double kHalfSure = 20;    // degrees of expected error that halve the confidence
constexpr float kShortest = 1e-3f;  // of an output vector that means a normal
constexpr int kSmoothing = 2;       // radius of the mean that a normal is compared with

std::string_view built_in_bytes() {
  return {vitrine_rooms_onnx, static_cast<size_t>(vitrine_rooms_onnx_end - vitrine_rooms_onnx)};
}

// Expected angle under the angular von Mises-Fisher distribution of Bae et al. 2021, degrees.
double expected_angle(double kappa) {
  const double tail = std::exp(-kappa * std::numbers::pi);
  return (2 * kappa / (kappa * kappa + 1) + tail * std::numbers::pi / (1 + tail)) * 180 / std::numbers::pi;
}

// A network that says nothing of its own doubts: less sure where normals change (algorithm of the monocular loss).
void smoothness_confidence(NormalMap& map) {
  const int w = map.normal.width(), h = map.normal.height();
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const Vec3f own = map.at(x, y);
      if (squared_length(own) == 0) continue;
      Vec3f sum{};
      for (int v = std::max(0, y - kSmoothing); v <= std::min(h - 1, y + kSmoothing); ++v)
        for (int u = std::max(0, x - kSmoothing); u <= std::min(w - 1, x + kSmoothing); ++u) sum += map.at(u, v);
      map.confidence.at(x, y) = length(sum) > 0 ? std::exp(-length(own - normalized(sum))) : 0;
    }
}

}  // namespace

struct NormalNetwork::State {
  OnnxConfig config;
  std::string where, digest;
  bool built_in = false;
  cv::dnn::Net net;

  [[noreturn]] void refuse(const std::string& what, const std::string& why, const std::string& hint, const char* code) const {
    throw Error(ErrorKind::Input, what, {.where = where, .why = why, .hint = hint, .code = code});
  }
};

std::string built_in_network_sha256() { return sha256_hex(built_in_bytes()); }

OnnxConfig built_in_network_config() {
  OnnxConfig c;
  c.max_side = 128;
  c.multiple = 16;
  c.mean = {0.5, 0.5, 0.5};
  c.deviation = {0.25, 0.25, 0.25};
  c.doubt = "kappa";
  c.space = "camera-opencv";
  return c;
}

NormalNetwork::NormalNetwork(const std::optional<std::filesystem::path>& file, const OnnxConfig& config)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.built_in = !file;
  s.config = config;
  s.where = file ? file->string() : "the network that is built in";
  const std::string read = file ? read_file(*file) : std::string();
  const std::string_view bytes = file ? std::string_view(read) : built_in_bytes();
  s.digest = sha256_hex(bytes);
  if (!config.sha256.empty() && config.sha256 != s.digest)
    s.refuse("the network is not the one that is expected", fmt::format("SHA-256 {} instead of {}", s.digest, config.sha256),
             "fetch it again, or correct normals.onnx.sha256", "WRONG_DIGEST");
  const std::vector<std::string> missing = unsupported_operators(onnx_operators(bytes, s.where));
  if (!missing.empty())
    s.refuse("the network uses operators that OpenCV 4.6 does not compute rightly", fmt::format("{}", fmt::join(missing, ", ")),
             "convolutional networks work, transformers do not; run it in its own program and use normals.source=files",
             "UNSUPPORTED_OPERATOR");
  try {
    s.net = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
    s.net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  } catch (const cv::Exception& e) {
    s.refuse("OpenCV cannot take this network in", e.err,
             "export it again with opset 12 and constant folding; README.md lists what works", "UNSUPPORTED_NETWORK");
  }
}

NormalNetwork::~NormalNetwork() = default;
const std::string& NormalNetwork::sha256() const { return state_->digest; }
bool NormalNetwork::built_in() const { return state_->built_in; }

std::pair<int, int> NormalNetwork::input_size(int width, int height) const {
  const OnnxConfig& c = state_->config;
  if (c.width > 0) return {c.width, c.height};
  const double scale = double(c.max_side) / std::max(width, height);
  const auto rounded = [&](int side) { return std::max(1, int(std::lround(scale * side / c.multiple))) * c.multiple; };
  return {rounded(width), rounded(height)};
}

NormalMap NormalNetwork::predict(const ImageF& srgb) {
  State& s = *state_;
  const OnnxConfig& c = s.config;
  const int w = srgb.width(), h = srgb.height();
  const bool planes_first = c.layout == "nchw";
  const int nchw[] = {1, 3, h, w}, nhwc[] = {1, h, w, 3};
  cv::Mat blob(4, planes_first ? nchw : nhwc, CV_32F);
  float* in = blob.ptr<float>();
  const size_t pixels = size_t(w) * size_t(h);
  for (size_t i = 0; i < pixels; ++i)
    for (size_t channel = 0; channel < 3; ++channel) {
      const size_t source = c.channels == "bgr" ? 2 - channel : channel;
      const float value = (srgb.data()[3 * i + source] - float(c.mean[channel])) / float(c.deviation[channel]);
      in[planes_first ? channel * pixels + i : 3 * i + channel] = value;
    }
  cv::Mat out;
  try {
    s.net.setInput(blob);
    out = s.net.forward();
  } catch (const cv::Exception& e) {
    s.refuse("the network cannot be run on a photo", fmt::format("input of {} x {}: {}", w, h, e.err),
             "its input size and layout go to normals.onnx.width, height, layout", "NETWORK_FAILED");
  }
  std::vector<int> shape(out.size.p, out.size.p + out.dims);
  const std::vector<int> told = shape;
  while (shape.size() > 3 && shape.front() == 1) shape.erase(shape.begin());
  const auto channels = [](int n) { return n == 3 || n == 4; };
  const bool out_planes = shape.size() == 3 && channels(shape[0]) && (planes_first || !channels(shape[2]));
  if (shape.size() != 3 || out.depth() != CV_32F || !(out_planes || channels(shape[2])))
    s.refuse("the network's output is no picture of normals", fmt::format("its shape is {}", fmt::join(told, " x ")),
             "its first output must be 1 x 3 x h x w, or 1 x 4 x h x w with kappa", "BAD_NETWORK_OUTPUT");
  const int count = out_planes ? shape[0] : shape[2], oh = out_planes ? shape[1] : shape[0],
            ow = out_planes ? shape[2] : shape[1];
  if (c.doubt == "kappa" && count != 4)
    s.refuse("the network has no fourth channel", fmt::format("its shape is {}", fmt::join(told, " x ")),
             "--set normals.onnx.doubt=smoothness", "BAD_NETWORK_OUTPUT");
  // A network of another task, or one that shrinks the photo to a code, has some other shape.
  if (std::abs(double(ow) * h - double(oh) * w) > 2.0 * std::max(w, h) || ow < 8 || oh < 8)
    s.refuse("the network's output does not have the photo's shape", fmt::format("{} x {} for a photo of {} x {}", ow, oh, w, h),
             "normals.onnx.width and height must be what it was trained for", "BAD_NETWORK_OUTPUT");
  NormalMap map(ow, oh);
  const float* p = out.ptr<float>();
  const size_t area = size_t(ow) * size_t(oh);
  for (size_t i = 0; i < area; ++i) {
    const auto value = [&](size_t channel) { return p[out_planes ? channel * area + i : size_t(count) * i + channel]; };
    Vec3f n{value(0), value(1), value(2)};
    if (c.output == "rgb") n = 2.f * n - Vec3f{1, 1, 1};
    const float size = length(n);
    if (!std::isfinite(size) || size < kShortest) continue;
    const double angle = c.doubt == "kappa" ? expected_angle(std::max(0.01, double(value(3)))) / kHalfSure : 0;
    map.set(int(i % size_t(ow)), int(i / size_t(ow)), n / size, float(1 / (1 + angle * angle)));
  }
  if (c.doubt == "smoothness") smoothness_confidence(map);
  return map;
}

}  // namespace vitrine
