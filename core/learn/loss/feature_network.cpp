#include "core/learn/loss/feature_network.h"

#include <omp.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <unordered_map>

#include <fmt/format.h>
#include <dnnl.hpp>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

using dnnl::memory;

constexpr const char* kPrefix = "features.";
// Normalisation of torchvision's pretrained networks.
constexpr std::array<float, 3> kMean{0.485f, 0.456f, 0.406f}, kDeviation{0.229f, 0.224f, 0.225f};

struct Convolution {
  int in = 0, out = 0;
  bool pool_before = false, ends_block = false;
  std::vector<float> weights, bias;  // [out, in, 3, 3], [out]

  // For the prepared size.
  int width = 0, height = 0;
  dnnl::primitive forward, backward;
  memory::desc source, target, forward_weights, forward_scratch, backward_scratch, backward_weights;
  memory forward_weights_memory, backward_weights_memory, bias_memory;
};

// A oneDNN view of our values; oneDNN does not accept const.
memory view(const memory::desc& desc, const dnnl::engine& engine, const float* values) {
  return memory(desc, engine, const_cast<float*>(values));
}

// Descriptions of a convolution by the same terms: oneDNN 3 (Debian 13) takes them as they are, oneDNN 2 (Debian 12) as one
// object.
template <class... Terms>
dnnl::convolution_forward::primitive_desc describe_forward(const dnnl::engine& engine, const dnnl::primitive_attr& attributes,
                                                           const Terms&... terms) {
#if DNNL_VERSION_MAJOR >= 3
  return {engine, terms..., attributes};
#else
  return {{terms...}, attributes, engine};
#endif
}
template <class... Terms>
dnnl::convolution_backward_data::primitive_desc describe_backward(const dnnl::engine& engine,
                                                                  const dnnl::primitive_attr& attributes,
                                                                  const dnnl::convolution_forward::primitive_desc& forward,
                                                                  const Terms&... terms) {
#if DNNL_VERSION_MAJOR >= 3
  return {engine, terms..., forward, attributes};
#else
  return {{terms...}, attributes, engine, forward};
#endif
}

void append_relu(dnnl::post_ops& after) {
#if DNNL_VERSION_MAJOR >= 3
  after.append_eltwise(dnnl::algorithm::eltwise_relu, 0.f, 0.f);
#else
  after.append_eltwise(1.f, dnnl::algorithm::eltwise_relu, 0.f, 0.f);
#endif
}

// Channels last; windows of 2x2, an odd last row or column is ignored.
void max_pool(std::span<const float> fine, int width, int height, int channels, std::vector<float>& out) {
  const size_t w = size_t(width / 2), h = size_t(height / 2), c = size_t(channels), row = size_t(width) * c;
  out.resize(w * h * c);
  for (size_t y = 0; y < h; ++y)
    for (size_t x = 0; x < w; ++x) {
      const float* from = fine.data() + 2 * y * row + 2 * x * c;
      float* to = out.data() + (y * w + x) * c;
      for (size_t k = 0; k < c; ++k) to[k] = std::max(std::max(from[k], from[c + k]), std::max(from[row + k], from[row + c + k]));
    }
}

// The gradient goes to the first largest value of each window; adds to `grad_fine`.
void max_pool_back(std::span<const float> fine, int width, int height, int channels, std::span<const float> grad,
                   std::span<float> grad_fine) {
  const size_t w = size_t(width / 2), h = size_t(height / 2), c = size_t(channels), row = size_t(width) * c;
  for (size_t y = 0; y < h; ++y)
    for (size_t x = 0; x < w; ++x)
      for (size_t k = 0; k < c; ++k) {
        const size_t corner = 2 * y * row + 2 * x * c + k;
        size_t best = corner;
        for (const size_t other : {corner + c, corner + row, corner + row + c})
          if (fine[other] > fine[best]) best = other;
        grad_fine[best] += grad[(y * w + x) * c + k];
      }
}

}  // namespace

struct FeatureNetwork::Impl {
  dnnl::engine engine{dnnl::engine::kind::cpu, 0};
  std::vector<Convolution> layers;
  std::vector<Feature> features;
  size_t used = 0;  // layers up to the last feature
  int width = 0, height = 0;

  void prepare_layer(Convolution& layer);
  void run(const dnnl::primitive& primitive, const memory::desc& scratch, std::unordered_map<int, memory> arguments) const {
    // more threads would change the sums with their number, and compete with our thread pool
    omp_set_num_threads(1);
    std::vector<char> space(scratch.get_size());
    arguments.emplace(DNNL_ARG_SCRATCHPAD, memory(scratch, engine, space.data()));
    dnnl::stream stream(engine);
    primitive.execute(stream, arguments);
    stream.wait();
  }
};

FeatureNetwork::FeatureNetwork(const std::filesystem::path& path) : impl_(std::make_unique<Impl>()) {
  const auto fail = [&](const std::string& why) {
    return Error(ErrorKind::Input, "a weights file is no network of this kind",
                 {.where = path.string(), .why = why, .hint = "see core/learn/loss/README.md", .code = "BAD_WEIGHTS"});
  };
  const std::map<std::string, Tensor> tensors = read_safetensors(path, kPrefix);
  std::map<int, const Tensor*> weights;  // by layer number
  for (const auto& [name, tensor] : tensors) {
    int number = -1;
    const char *begin = name.data() + std::string_view(kPrefix).size(), *end = name.data() + name.size();
    const auto parsed = std::from_chars(begin, end, number);
    if (parsed.ec == std::errc() && std::string_view(parsed.ptr, end) == ".weight" && tensor.shape.size() == 4)
      weights[number] = &tensor;
  }
  if (weights.empty()) throw fail("it has no tensor features.<i>.weight of four dimensions");
  int channels = 3, last = -1;
  for (const auto& [number, tensor] : weights) {
    const std::string name = fmt::format("{}{}", kPrefix, number);
    if (tensor->shape[1] != size_t(channels) || tensor->shape[2] != 3 || tensor->shape[3] != 3)
      throw fail(fmt::format("{}.weight is {}, expected [*, {}, 3, 3]", name, fmt::join(tensor->shape, "x"), channels));
    const auto bias = tensors.find(name + ".bias");
    if (bias == tensors.end() || bias->second.values.size() != tensor->shape[0])
      throw fail(name + ".bias is missing or does not fit");
    if (last >= 0 && number - last != 2 && number - last != 3)
      throw fail(fmt::format("convolutions {} and {} are neither 2 nor 3 layers apart", last, number));
    Convolution layer;
    layer.in = channels;
    layer.out = channels = int(tensor->shape[0]);
    layer.pool_before = last >= 0 && number - last == 3;
    layer.weights = tensor->values;
    layer.bias = bias->second.values;
    if (layer.pool_before) impl_->layers.back().ends_block = true;
    impl_->layers.push_back(std::move(layer));
    last = number;
  }
  impl_->layers.back().ends_block = true;
}

FeatureNetwork::~FeatureNetwork() = default;

void FeatureNetwork::Impl::prepare_layer(Convolution& layer) {
  using tag = memory::format_tag;
  const auto f32 = memory::data_type::f32;
  const memory::dims strides{1, 1}, padding{1, 1}, kernel{layer.out, layer.in, 3, 3};
  layer.source = {{1, layer.in, layer.height, layer.width}, f32, tag::nhwc};
  layer.target = {{1, layer.out, layer.height, layer.width}, f32, tag::nhwc};
  const memory::desc any_weights(kernel, f32, tag::any), bias({layer.out}, f32, tag::x), plain(kernel, f32, tag::oihw);
  dnnl::primitive_attr relu, none;
  dnnl::post_ops after;
  append_relu(after);
  relu.set_post_ops(after);
  for (auto* attributes : {&relu, &none}) attributes->set_scratchpad_mode(dnnl::scratchpad_mode::user);
  const auto algorithm = dnnl::algorithm::convolution_direct;
  const auto training = dnnl::prop_kind::forward_training;
  const auto forward = describe_forward(engine, relu, training, algorithm, layer.source, any_weights, bias, layer.target, strides,
                                        padding, padding);
  const auto hint =
      describe_forward(engine, none, training, algorithm, layer.source, any_weights, layer.target, strides, padding, padding);
  const auto backward =
      describe_backward(engine, none, hint, algorithm, layer.source, any_weights, layer.target, strides, padding, padding);
  layer.forward = dnnl::convolution_forward(forward);
  layer.backward = dnnl::convolution_backward_data(backward);
  layer.forward_scratch = forward.scratchpad_desc();
  layer.backward_scratch = backward.scratchpad_desc();
  const memory given = view(plain, engine, layer.weights.data());
  layer.forward_weights_memory = memory(forward.weights_desc(), engine);
  layer.backward_weights_memory = memory(backward.weights_desc(), engine);
  layer.bias_memory = view(bias, engine, layer.bias.data());
  omp_set_num_threads(1);
  dnnl::stream stream(engine);
  for (memory* to : {&layer.forward_weights_memory, &layer.backward_weights_memory}) {
    memory from = given;
    dnnl::reorder(from, *to).execute(stream, from, *to);
  }
  stream.wait();
}

std::span<const FeatureNetwork::Feature> FeatureNetwork::prepare(int width, int height) {
  Impl& n = *impl_;
  if (width == n.width && height == n.height) return n.features;
  n.features.clear();
  n.used = 0;
  n.width = width;
  n.height = height;
  for (size_t i = 0; i < n.layers.size(); ++i) {
    Convolution& layer = n.layers[i];
    if (layer.pool_before) width /= 2, height /= 2;
    if (width < 1 || height < 1) break;
    layer.width = width;
    layer.height = height;
    n.prepare_layer(layer);
    if (!layer.ends_block) continue;
    n.features.push_back({i, width, height, layer.out});
    n.used = i + 1;
  }
  return n.features;
}

void FeatureNetwork::forward(std::span<const float> rgb, Activations& out) const {
  const Impl& n = *impl_;
  VITRINE_CHECK(rgb.size() == 3 * size_t(n.width) * size_t(n.height), "a picture of another size than the network is ready for");
  out.input.resize(rgb.size());
  for (size_t i = 0; i < rgb.size(); ++i) out.input[i] = (rgb[i] - kMean[i % 3]) / kDeviation[i % 3];
  out.after_convolution.resize(n.used);
  std::vector<float> pooled;
  for (size_t i = 0; i < n.used; ++i) {
    const Convolution& layer = n.layers[i];
    const std::vector<float>* source = i == 0 ? &out.input : &out.after_convolution[i - 1];
    if (layer.pool_before) {
      const Convolution& before = n.layers[i - 1];
      max_pool(*source, before.width, before.height, before.out, pooled);
      source = &pooled;
    }
    std::vector<float>& target = out.after_convolution[i];
    target.resize(size_t(layer.width) * size_t(layer.height) * size_t(layer.out));
    n.run(layer.forward, layer.forward_scratch,
          {{DNNL_ARG_SRC, view(layer.source, n.engine, source->data())},
           {DNNL_ARG_WEIGHTS, layer.forward_weights_memory},
           {DNNL_ARG_BIAS, layer.bias_memory},
           {DNNL_ARG_DST, view(layer.target, n.engine, target.data())}});
  }
}

void FeatureNetwork::backward(const Activations& activations, std::span<const std::vector<float>> grad,
                              std::span<float> grad_rgb) const {
  const Impl& n = *impl_;
  VITRINE_CHECK(grad.size() == n.features.size(), "gradients of {} features, the network has {}", grad.size(), n.features.size());
  std::vector<float> current, source;
  size_t feature = n.features.size();
  for (size_t i = n.used; i-- > 0;) {
    const Convolution& layer = n.layers[i];
    const std::vector<float>& value = activations.after_convolution[i];
    current.resize(value.size(), 0.f);
    if (feature > 0 && n.features[feature - 1].convolution == i) {
      --feature;
      for (size_t k = 0; k < current.size(); ++k) current[k] += grad[feature][k];
    }
    for (size_t k = 0; k < current.size(); ++k)
      if (!(value[k] > 0)) current[k] = 0;
    source.assign(size_t(layer.width) * size_t(layer.height) * size_t(layer.in), 0.f);
    n.run(layer.backward, layer.backward_scratch,
          {{DNNL_ARG_DIFF_DST, view(layer.target, n.engine, current.data())},
           {DNNL_ARG_WEIGHTS, layer.backward_weights_memory},
           {DNNL_ARG_DIFF_SRC, view(layer.source, n.engine, source.data())}});
    if (layer.pool_before) {
      const Convolution& before = n.layers[i - 1];
      current.assign(activations.after_convolution[i - 1].size(), 0.f);
      max_pool_back(activations.after_convolution[i - 1], before.width, before.height, before.out, source, current);
    } else {
      current.swap(source);
    }
  }
  for (size_t k = 0; k < grad_rgb.size(); ++k) grad_rgb[k] = current[k] / kDeviation[k % 3];
}

}  // namespace vitrine
