// The feature network against a plain one in doubles, its gradient against differences of that one, and files that are no
// network.
#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/learn/loss/feature_network.h"
#include "core/learn/loss/lpips.h"
#include "tests/core/learn/loss/test_frame.h"
#include "tests/support/error_of.h"
#include "tests/support/feature_network_file.h"

namespace vitrine {
namespace {

using testing::NetworkLayer;
using testing::small_network;
using testing::write_network;

struct Map {
  int w, h, c;
  std::vector<double> v;  // channels last
};

Map plain_convolution(const Map& in, const NetworkLayer& l) {
  Map out{in.w, in.h, l.out, std::vector<double>(size_t(in.w * in.h * l.out))};
  for (int y = 0; y < in.h; ++y)
    for (int x = 0; x < in.w; ++x)
      for (int o = 0; o < l.out; ++o) {
        double sum = l.bias[size_t(o)];
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i)
            for (int c = 0; c < l.in; ++c)
              if (x + i >= 0 && x + i < in.w && y + j >= 0 && y + j < in.h)
                sum += in.v[size_t(((y + j) * in.w + x + i) * in.c + c)] *
                       l.weights[size_t(((o * l.in + c) * 3 + j + 1) * 3 + i + 1)];
        out.v[size_t((y * in.w + x) * l.out + o)] = std::max(0.0, sum);
      }
  return out;
}

Map plain_pool(const Map& in) {
  Map out{in.w / 2, in.h / 2, in.c, {}};
  for (int y = 0; y < out.h; ++y)
    for (int x = 0; x < out.w; ++x)
      for (int c = 0; c < in.c; ++c) {
        double best = 0;  // after a ReLU
        for (int j = 0; j < 2; ++j)
          for (int i = 0; i < 2; ++i) best = std::max(best, in.v[size_t(((2 * y + j) * in.w + 2 * x + i) * in.c + c)]);
        out.v.push_back(best);
      }
  return out;
}

std::vector<Map> plain_features(const std::vector<NetworkLayer>& layers, const std::vector<double>& planes, int w, int h) {
  const double mean[] = {0.485, 0.456, 0.406}, deviation[] = {0.229, 0.224, 0.225};
  Map m{w, h, 3, std::vector<double>(planes.size())};
  for (int i = 0; i < w * h; ++i)
    for (int c = 0; c < 3; ++c) m.v[size_t(3 * i + c)] = (planes[size_t(c * w * h + i)] - mean[c]) / deviation[c];
  std::vector<Map> features;
  for (size_t l = 0; l < layers.size(); ++l) {
    if (l > 0 && layers[l].number - layers[l - 1].number == 3) features.push_back(m), m = plain_pool(m);
    if (m.v.empty()) return features;  // nothing is left to look at
    m = plain_convolution(m, layers[l]);
  }
  features.push_back(m);
  return features;
}

double plain_distance(const std::vector<NetworkLayer>& layers, const std::vector<double>& x, const std::vector<Map>& photo, int w,
                      int h) {
  const std::vector<Map> ours = plain_features(layers, x, w, h);
  double total = 0;
  for (size_t t = 0; t < ours.size(); ++t) {
    const Map &a = ours[t], &b = photo[t];
    double sum = 0;
    for (size_t p = 0; p < a.v.size(); p += size_t(a.c)) {
      double aa = 1e-8, bb = 1e-8;
      for (size_t c = 0; c < size_t(a.c); ++c) aa += a.v[p + c] * a.v[p + c], bb += b.v[p + c] * b.v[p + c];
      for (size_t c = 0; c < size_t(a.c); ++c) {
        const double d = a.v[p + c] / std::sqrt(aa) - b.v[p + c] / std::sqrt(bb);
        sum += d * d;
      }
    }
    total += sum / (double(a.w) * a.h) / double(ours.size());
  }
  return total;
}

std::unique_ptr<Loss> perceptual(const fs::path& weights, int crop = 128, int every = 1) {
  return make_perceptual_loss(weights.string(), crop, every);
}

class Perceptual : public ::testing::TestWithParam<std::pair<int, int>> {};

TEST_P(Perceptual, ValueAndGradientAreThoseOfAPlainNetworkInDoubles) {
  const auto [w, h] = GetParam();
  const TemporaryFolder folder;
  const std::vector<NetworkLayer> layers = small_network();
  write_network(folder.path() / "net.safetensors", layers);
  TestFrame frame(w, h, false);
  LossGradient gradient = frame.gradient();
  const double value = perceptual(folder.path() / "net.safetensors")->evaluate(frame.input(), 1, gradient);
  std::vector<double> x(frame.prediction.begin(), frame.prediction.end()), y(frame.target.begin(), frame.target.end());
  const std::vector<Map> photo = plain_features(layers, y, w, h);
  EXPECT_NEAR(value, plain_distance(layers, x, photo, w, h), 1e-5);
  double largest = 0, worst = 0;
  size_t off = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    constexpr double step = 1e-6;
    const double kept = x[i];
    x[i] = kept + step;
    const double up = plain_distance(layers, x, photo, w, h);
    x[i] = kept - step;
    const double slope = (up - plain_distance(layers, x, photo, w, h)) / (2 * step);
    x[i] = kept;
    largest = std::max(largest, std::abs(slope));
    const double difference = std::abs(slope - frame.grad_prediction[i]);
    worst = std::max(worst, difference);
    off += difference > 1e-4;
  }
  EXPECT_GT(largest, 0.01);
  EXPECT_LT(worst, 2e-4 * largest + 1e-6) << off << " of " << x.size();
}
INSTANTIATE_TEST_SUITE_P(Sizes, Perceptual, ::testing::Values(std::pair{8, 8}, std::pair{11, 7}, std::pair{1, 5}));

TEST(PerceptualLoss, LooksAtOneCropOfEverySoManySteps) {
  const TemporaryFolder folder;
  write_network(folder.path() / "net.safetensors", small_network());
  const auto loss = perceptual(folder.path() / "net.safetensors", 8, 3);
  TestFrame frame(40, 30, false);
  const auto touched = [&](uint64_t step) {
    std::fill(frame.grad_prediction.begin(), frame.grad_prediction.end(), 0.f);
    LossInput input = frame.input();
    input.step = step;
    LossGradient g = frame.gradient();
    loss->evaluate(input, 1, g);
    std::vector<size_t> pixels;
    for (size_t i = 0; i < 1200; ++i)
      if (frame.grad_prediction[i] != 0) pixels.push_back(i);
    return pixels;
  };
  const auto first = touched(0);
  EXPECT_GT(first.size(), 30u);
  for (size_t p : first) {
    EXPECT_LT(p % 40 - first[0] % 40 + 8, 16u);
    EXPECT_LT(p / 40 - first[0] / 40, 8u);
  }
  EXPECT_TRUE(touched(1).empty());
  EXPECT_NE(touched(3), first);
  EXPECT_EQ(touched(0), first);
}

TEST(PerceptualLoss, SameBitsForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  write_network(folder.path() / "net.safetensors", small_network());
  const auto run = [&](int threads) {
    set_thread_limit(threads);
    TestFrame frame(61, 47, false);
    LossGradient g = frame.gradient();
    const double value = perceptual(folder.path() / "net.safetensors", 40)->evaluate(frame.input(), 1, g);
    set_thread_limit(0);
    return std::pair(value, frame.grad_prediction);
  };
  EXPECT_EQ(run(1), run(2));
  EXPECT_EQ(run(1), run(5));
}

const std::vector<std::vector<float>> kHeads = {{0.5f, 0, 1, 2, 0.25f, 0, 3, 1}, {1, 0.1f, 0, 2, 4, 0.7f}};

ImageF picture(int w, int h, uint64_t seed) {
  ImageF out(w, h, 3);
  Rng rng(seed);
  for (float& v : out.data()) v = rng.uniform();
  return out;
}

std::vector<double> planes_of(const ImageF& picture) {
  std::vector<double> out;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x) out.push_back(double(picture.at(x, y, c)));
  return out;
}

TEST(Lpips, IsTheWeightedDistanceOfTheFeaturesOfAPlainNetwork) {
  const TemporaryFolder folder;
  const std::vector<NetworkLayer> layers = small_network();
  write_network(folder.path() / "lpips.safetensors", layers, kHeads);
  constexpr int w = 13, h = 10;
  const ImageF a = picture(w, h, 3), b = picture(w, h, 4);
  const auto fa = plain_features(layers, planes_of(a), w, h), fb = plain_features(layers, planes_of(b), w, h);
  double expected = 0;
  for (size_t t = 0; t < fa.size(); ++t) {
    const size_t channels = size_t(fa[t].c);
    double sum = 0;
    for (size_t p = 0; p < fa[t].v.size(); p += channels) {
      double aa = 0, bb = 0;
      for (size_t c = 0; c < channels; ++c) aa += std::pow(fa[t].v[p + c], 2), bb += std::pow(fb[t].v[p + c], 2);
      for (size_t c = 0; c < channels; ++c)
        sum += double(kHeads[t][c]) *
               std::pow(fa[t].v[p + c] / (std::sqrt(aa) + 1e-10) - fb[t].v[p + c] / (std::sqrt(bb) + 1e-10), 2);
    }
    expected += sum / (double(fa[t].w) * fa[t].h);
  }
  Lpips lpips(folder.path() / "lpips.safetensors");
  EXPECT_GT(expected, 0.1);
  EXPECT_NEAR(lpips.distance(a, b), expected, 1e-4 * expected);
  EXPECT_LT(lpips.distance(a, a), 1e-20);
}

TEST(Lpips, FilesWithoutItsWeightsAreRefused) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "lpips.safetensors";
  const auto complaint = [&] { return std::string(error_of([&] { Lpips lpips(path); }).what()); };
  write_network(path, small_network());
  EXPECT_NE(complaint().find("lin0.model.1.weight is missing"), std::string::npos) << complaint();
  write_network(path, small_network(), {kHeads[0]});
  EXPECT_NE(complaint().find("lin1.model.1.weight is missing"), std::string::npos) << complaint();
  write_network(path, small_network(), {kHeads[1], kHeads[1]});
  EXPECT_NE(complaint().find("has 6 values for 8 channels"), std::string::npos) << complaint();
}

TEST(PerceptualLoss, FilesThatAreNoNetworkAreTold) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "net.safetensors";
  const auto complaint = [&] { return std::string(error_of([&] { FeatureNetwork network(path); }).what()); };
  const auto expect = [&](const char* part) {
    const std::string text = complaint();
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_NE(text.find("net.safetensors"), std::string::npos) << text;
  };
  expect("cannot be opened");
  write_file(path, "PK\3\4 some zip file");
  expect("not a safetensors file");
  std::vector<NetworkLayer> layers = small_network();
  write_network(path, layers);
  const std::string whole = read_file(path);
  write_file(path, whole.substr(0, whole.size() - 5));
  expect("do not lie in the file");
  write_file(path, whole.substr(0, 40));
  expect("cut short");
  layers[1].in = 8, layers[1].weights.resize(8 * 8 * 9);
  write_network(path, layers);
  expect("expected [*, 9, 3, 3]");
  layers = small_network();
  layers[2].number = 9;
  write_network(path, layers);
  expect("neither 2 nor 3");
  layers = small_network();
  layers[0].bias[2] = std::numeric_limits<float>::quiet_NaN();
  write_network(path, layers);
  expect("no number");
  write_network(path, {});
  expect("no tensor");
}

}  // namespace
}  // namespace vitrine
