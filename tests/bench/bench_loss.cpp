// Losses over the picture of one training step, and the perceptual loss with a network of VGG16's size (random weights: the
// time is the same).
#include <benchmark/benchmark.h>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "core/learn/loss/loss_set.h"

namespace vitrine {
namespace {

struct Picture {
  View view;
  std::vector<float> prediction, target, grad;
  Picture(int width, int height) {
    view.intrinsics = {width, height, 1.0 * width, 1.0 * width, 0.5 * width, 0.5 * height};
    Rng rng(1);
    for (auto* planes : {&prediction, &target})
      for (size_t i = 0; i < 3 * size_t(width) * size_t(height); ++i) planes->push_back(rng.uniform());
    grad.resize(prediction.size());
  }
  LossInput input() const { return {.view = &view, .prediction_srgb = prediction, .target_srgb = target}; }
};

void picture_loss(benchmark::State& state, const char* name) {
  Picture picture(480, 270);
  LossSet losses;
  LossTerm& term = losses.term(name);
  for (auto _ : state) {
    LossGradient gradient{.prediction_srgb = picture.grad};
    benchmark::DoNotOptimize(term.loss->evaluate(picture.input(), 1, gradient));
  }
}
BENCHMARK_CAPTURE(picture_loss, l1, "l1")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
BENCHMARK_CAPTURE(picture_loss, dssim, "dssim")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void write_vgg16(const fs::path& path) {
  std::string header = "{", data;
  Rng rng(2);
  int in = 3, number = 0;
  const auto tensor = [&](const char* what, const std::string& shape, size_t count, float scale) {
    header += fmt::format(R"({}"features.{}.{}":{{"dtype":"F32","shape":[{}],"data_offsets":[{},{}]}})",
                          header.size() > 1 ? "," : "", number, what, shape, data.size(), data.size() + 4 * count);
    for (size_t i = 0; i < count; ++i) {
      const float v = scale * (rng.uniform() - 0.5f);
      data.append(reinterpret_cast<const char*>(&v), 4);
    }
  };
  for (int out : {64, 64, 0, 128, 128, 0, 256, 256, 256, 0, 512, 512, 512, 0, 512, 512, 512}) {
    if (out > 0) {
      tensor("weight", fmt::format("{},{},3,3", out, in), size_t(out * in * 9), 1 / std::sqrt(float(in)));
      tensor("bias", fmt::format("{}", out), size_t(out), 0.1f);
      in = out;
      ++number;  // its ReLU
    }
    ++number;
  }
  header += "}";
  std::string length(8, '\0');
  for (size_t i = 0; i < 8; ++i) length[i] = char(header.size() >> (8 * i) & 255);
  write_file(path, length + header + data);
}

void perceptual_vgg16_crop128(benchmark::State& state) {
  const TemporaryFolder folder;
  write_vgg16(folder.path() / "vgg16.safetensors");
  Picture picture(480, 270);
  const auto loss = make_perceptual_loss((folder.path() / "vgg16.safetensors").string(), 128, 1);
  LossInput input = picture.input();
  for (auto _ : state) {
    LossGradient gradient{.prediction_srgb = picture.grad};
    benchmark::DoNotOptimize(loss->evaluate(input, 1, gradient));
    ++input.step;
  }
}
BENCHMARK(perceptual_vgg16_crop128)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

}  // namespace
}  // namespace vitrine
