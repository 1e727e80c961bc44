#include "stages/normals/normals.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/hash.h"
#include "core/observe/network/photo_network.h"

// Embeds the network file through the assembler; the build defines its path.
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
constexpr float kShortest = 1e-3f;  // shortest output vector accepted as a normal
constexpr int kSmoothing = 2;       // radius of the mean that a normal is compared with

std::string_view built_in_bytes() {
  return {vitrine_rooms_onnx, static_cast<size_t>(vitrine_rooms_onnx_end - vitrine_rooms_onnx)};
}

// Expected angle under the angular von Mises-Fisher distribution of Bae et al. 2021, degrees.
double expected_angle(double kappa) {
  const double tail = std::exp(-kappa * std::numbers::pi);
  return (2 * kappa / (kappa * kappa + 1) + tail * std::numbers::pi / (1 + tail)) * 180 / std::numbers::pi;
}

// Confidence for a network without one: lower where normals change (algorithm of the monocular loss).
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
  bool built_in;
  PhotoNetwork network;
};

std::string built_in_network_sha256() { return sha256_hex(built_in_bytes()); }

OnnxConfig built_in_network_config() {
  OnnxConfig c;
  c.input.max_side = 128;
  c.input.multiple = 16;
  c.input.mean = {0.5, 0.5, 0.5};
  c.input.deviation = {0.25, 0.25, 0.25};
  c.doubt = NormalDoubt::Kappa;
  c.space = "camera-opencv";
  return c;
}

NormalNetwork::NormalNetwork(const std::optional<std::filesystem::path>& file, const OnnxConfig& config) {
  const std::string read = file ? read_file(*file) : std::string();
  state_.reset(new State{config, !file,
                         PhotoNetwork(file ? std::string_view(read) : built_in_bytes(),
                                      {.where = file ? file->string() : "the network that is built in",
                                       .input = config.input,
                                       .options = "normals.onnx",
                                       .instead = "use normals.source=files",
                                       .unlike = "the network's output is no picture of normals",
                                       .shape_hint = "its first output must be 1 x 3 x h x w, or 1 x 4 x h x w with kappa",
                                       .fits = [](int channels) { return channels == 3 || channels == 4; }})});
}

NormalNetwork::~NormalNetwork() = default;
const std::string& NormalNetwork::sha256() const { return state_->network.sha256(); }
bool NormalNetwork::built_in() const { return state_->built_in; }

std::pair<int, int> NormalNetwork::input_size(int width, int height) const { return state_->config.input.size_of(width, height); }

NormalMap NormalNetwork::predict(const ImageF& srgb) {
  const OnnxConfig& c = state_->config;
  const NetworkOutput out = state_->network.run(srgb);
  if (c.doubt == NormalDoubt::Kappa && out.channels != 4)
    throw Error(ErrorKind::Input, "the network has no fourth channel",
                {.where = state_->network.desc().where,
                 .why = fmt::format("its shape is {}", out.shape),
                 .hint = "--set normals.onnx.doubt=smoothness",
                 .code = "BAD_NETWORK_OUTPUT"});
  NormalMap map(out.width, out.height);
  for (size_t i = 0; i < out.pixel_count(); ++i) {
    Vec3f n{out.at(i, 0), out.at(i, 1), out.at(i, 2)};
    if (c.output == NormalEncoding::Rgb) n = 2.f * n - Vec3f{1, 1, 1};
    const float size = length(n);
    if (!std::isfinite(size) || size < kShortest) continue;
    const double angle = c.doubt == NormalDoubt::Kappa ? expected_angle(std::max(0.01, double(out.at(i, 3)))) / kHalfSure : 0;
    map.set(int(i % size_t(out.width)), int(i / size_t(out.width)), n / size, float(1 / (1 + angle * angle)));
  }
  if (c.doubt == NormalDoubt::Smoothness) smoothness_confidence(map);
  return map;
}

}  // namespace vitrine
