// The losses of a training step as kernels for a GPU against those of the CPU.
#include "core/learn/loss/blocks/loss_blocks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/learn/loss/loss_set.h"
#include "tests/core/learn/loss/test_frame.h"

namespace vitrine {
namespace {

using blocks::BlockLoops, blocks::BlockLoss, blocks::F32, blocks::LossFactors, blocks::LossFrame;

constexpr float kFactor = 0.7f;

// Pixels of a coat, in weighted frames alone.
std::vector<float> coat_of(const TestFrame& frame) {
  std::vector<float> coat(frame.ignore.size());
  for (size_t i = 0; i < coat.size(); ++i) coat[i] = i % 5 == 0 ? 0.6f : 0.f;
  return coat;
}

// Without `coat`.
LossFrame loss_frame(TestFrame& frame, bool targets) {
  const auto data = [&](std::vector<float>& values) { return values.empty() ? nullptr : values.data(); };
  const Intrinsics& k = frame.view.intrinsics;
  LossFrame f{};
  f.view.camera = {F32(k.fx), F32(k.fy), F32(k.cx), F32(k.cy), cast<F32>(frame.view.cam_from_world.rotation), {}, {}};
  f.view.width = k.width;
  f.view.height = k.height;
  f.prediction = frame.prediction.data();
  f.target = frame.target.data();
  f.weight = data(frame.weight);
  f.features = 12;
  for (const AovRow& r : kAovs)
    for (size_t c = 0; r.feature && c < static_cast<size_t>(r.width); ++c)
      f.planes.features[LossFrame::channel(r.id) + c] = frame.raster.plane(r.id).data() + c * k.pixel_count();
  f.planes.zdepth = frame.raster.plane(Aov::ZDepth).data();
  f.planes.alpha = frame.raster.plane(Aov::Alpha).data();
  f.planes.distortion = frame.raster.plane(Aov::Distortion).data();
  if (!targets) return f;
  f.specular = data(frame.specular);
  f.transparent = data(frame.transparent);
  f.object = data(frame.object);
  f.ignore = data(frame.ignore);
  f.normals = data(frame.normals);
  f.normal_confidence = data(frame.confidence);
  return f;
}

// Gradients of the picture, of all planes and of the surfels, null planes as zeros.
struct LossResults {
  double total = 0, term = 0, mean_error = 0;
  std::vector<float> picture, planes[kAovCount], opacity, log_scale;
  bool operator==(const LossResults&) const = default;
};

LossResults results_of_blocks(TestFrame frame, bool targets, BlockLoss loss, uint64_t seed) {
  BlockLoops loops(seed);
  blocks::LossBlocks<BlockLoops> losses;
  LossFrame f = loss_frame(frame, targets);
  const std::vector<float> coat = coat_of(frame);
  if (targets && !coat.empty()) f.coat = coat.data();
  LossFactors factors;
  factors[loss] = kFactor;
  LossResults e;
  e.picture.assign(frame.prediction.size(), 9.f);
  std::vector<float> error(f.pixels());
  const blocks::GradientPlanes g = losses.evaluate(loops, f, factors, e.picture.data(), error.data());
  EXPECT_EQ(g.error, error.data());
  const auto keep = [&](Aov a, size_t channel, const float* plane) {
    auto& to = e.planes[size_t(a)];
    to.resize(size_t(row(a).width) * f.pixels());
    if (plane != nullptr) std::copy_n(plane, f.pixels(), to.data() + channel * f.pixels());
  };
  for (const AovRow& r : kAovs)
    for (size_t c = 0; r.feature && c < size_t(r.width); ++c) keep(r.id, c, g.features[LossFrame::channel(r.id) + c]);
  keep(Aov::ZDepth, 0, g.zdepth);
  keep(Aov::Alpha, 0, g.alpha);
  keep(Aov::MedianZ, 0, g.median_z);
  keep(Aov::Distortion, 0, g.distortion);
  e.opacity.assign(frame.layer.size(), 0.f);
  e.log_scale.assign(2 * frame.layer.size(), 0.f);
  blocks::SurfelArrays surfels{};
  surfels.opacity = frame.layer.values(Attribute::Opacity).data();
  surfels.log_scale = frame.layer.values(Attribute::LogScale).data();
  surfels.count = uint32_t(frame.layer.size());
  blocks::SurfelGradients out{};
  out.opacity = e.opacity.data();
  out.log_scale = e.log_scale.data();
  losses.regularise(loops, surfels, out);
  const auto values = losses.values(loops);
  e.total = values.total;
  e.term = values.terms[loss];
  e.mean_error = values.mean_error;
  return e;
}

LossResults results_of_cpu(TestFrame frame, bool targets, std::string_view loss) {
  LossInput input = frame.input();
  const std::vector<float> coat = coat_of(frame);
  input.targets.coat = coat;
  if (!targets) input.targets = {};
  LossGradient gradient = frame.gradient();
  LossResults e;
  e.term = make(loss)->evaluate(input, kFactor, gradient);
  e.total = double(kFactor) * e.term;
  e.picture = frame.grad_prediction;
  for (const AovRow& r : kAovs) e.planes[size_t(r.id)] = frame.grad_raster.planes[size_t(r.id)];
  const auto values = [](const auto& span) { return std::vector<float>(span.begin(), span.end()); };
  e.opacity = values(frame.grad_layer.values(Attribute::Opacity));
  e.log_scale = values(frame.grad_layer.values(Attribute::LogScale));
  for (size_t i = 0; i < frame.prediction.size(); ++i)
    e.mean_error += std::abs(frame.prediction[i] - frame.target[i]) / double(frame.prediction.size());
  return e;
}

// Differences up to `tolerance` of the largest value. Returns the largest.
double expect_near(const std::vector<float>& there, const std::vector<float>& here, double tolerance) {
  double largest = 0;
  for (const float v : here) largest = std::max(largest, double(std::abs(v)));
  EXPECT_EQ(there.size(), here.size());
  for (size_t i = 0; i < std::min(there.size(), here.size()); ++i) EXPECT_NEAR(there[i], here[i], tolerance * largest) << i;
  return largest;
}

class LossBlocksTest : public ::testing::TestWithParam<std::string> {};

TEST_P(LossBlocksTest, AgreesWithTheCpuInAnyOrder) {
  const auto loss = blocks::block_loss(GetParam());
  ASSERT_TRUE(loss);
  for (const auto& [width, height] : {std::pair{53, 38}, std::pair{5, 3}})
    for (const bool weighted : {false, true}) {
      SCOPED_TRACE(std::to_string(width) + (weighted ? ", weighted" : ""));
      const TestFrame frame(width, height, weighted, 4);
      const LossResults cpu = results_of_cpu(frame, true, GetParam()), there = results_of_blocks(frame, true, *loss, 0);
      EXPECT_EQ(results_of_blocks(frame, true, *loss, 11), there);
      EXPECT_GT(cpu.term, 0);
      EXPECT_NEAR(there.term, cpu.term, 3e-6 * cpu.term);
      EXPECT_NEAR(there.total, cpu.total, 3e-6 * cpu.total);
      EXPECT_NEAR(there.mean_error, cpu.mean_error, 1e-6);
      double largest = expect_near(there.picture, cpu.picture, 3e-5);
      for (const AovRow& r : kAovs) {
        SCOPED_TRACE(std::string(r.name));
        largest += expect_near(there.planes[size_t(r.id)], cpu.planes[size_t(r.id)], 2e-5);
      }
      largest += expect_near(there.opacity, cpu.opacity, 1e-6) + expect_near(there.log_scale, cpu.log_scale, 1e-6);
      EXPECT_GT(largest, 0);
    }
}
INSTANTIATE_TEST_SUITE_P(Terms, LossBlocksTest,
                         ::testing::Values("l1", "dssim", "normal_consistency", "distortion", "opacity", "scale", "specular_mask",
                                           "transmission_mask", "object_mask", "monocular_normal"),
                         [](const auto& info) { return info.param; });

TEST(LossBlocks, EveryLossOfTheRegistryButTwoHasAKernel) {
  size_t count = 0;
  for (const LossFactory& f : loss_registry()) {
    const bool traced_or_network = f.name == "first_hit" || f.name == "perceptual";
    EXPECT_EQ(blocks::block_loss(f.name).has_value(), !traced_or_network) << f.name;
    if (traced_or_network) continue;
    EXPECT_EQ(static_cast<size_t>(*blocks::block_loss(f.name)), count) << "the order is that of the registry";
    ++count;
  }
  EXPECT_EQ(count, blocks::kBlockLossCount);
}

TEST(LossBlocks, WithoutTargetsTheirLossesAreSilent) {
  const TestFrame frame(23, 19, true);
  for (const BlockLoss loss :
       {BlockLoss::SpecularMask, BlockLoss::TransmissionMask, BlockLoss::ObjectMask, BlockLoss::MonocularNormal}) {
    const LossResults there = results_of_blocks(frame, false, loss, 0);
    EXPECT_EQ(there.total, 0);
    for (const auto& plane : there.planes)
      for (const float g : plane) ASSERT_EQ(g, 0.f);
  }
}

// The weighted sum of all losses in one call is the sum of the calls for each.
TEST(LossBlocks, AllLossesAddUp) {
  TestFrame frame(33, 29, true, 6);
  BlockLoops loops(3);
  blocks::LossBlocks<BlockLoops> losses;
  const LossFrame f = loss_frame(frame, true);
  LossFactors factors;
  double total = 0;
  std::vector<float> alpha(f.pixels()), normal(f.pixels());
  for (const LossFactory& factory : loss_registry()) {
    const auto loss = blocks::block_loss(factory.name);
    if (!loss || *loss == BlockLoss::Opacity || *loss == BlockLoss::Scale) continue;
    factors[*loss] = kFactor;
    TestFrame alone = frame;
    LossGradient gradient = alone.gradient();
    total += double(kFactor) * factory.make()->evaluate(alone.input(), kFactor, gradient);
    for (size_t i = 0; i < f.pixels(); ++i) {
      alpha[i] += alone.grad_raster.plane(Aov::Alpha)[i];
      normal[i] += alone.grad_raster.plane(Aov::Normal)[i];
    }
  }
  std::vector<float> picture(frame.prediction.size()), error(f.pixels());
  const blocks::GradientPlanes g = losses.evaluate(loops, f, factors, picture.data(), error.data());
  EXPECT_NEAR(losses.values(loops).total, total, 3e-6 * total);
  EXPECT_GT(expect_near({g.alpha, g.alpha + f.pixels()}, alpha, 2e-5), 0);
  const float* const there = g.features[LossFrame::channel(Aov::Normal)];
  EXPECT_GT(expect_near({there, there + f.pixels()}, normal, 2e-5), 0);
}

TEST(LossBlocks, APictureThatIsIgnoredHasNoMaskLosses) {
  TestFrame frame(20, 14, true);
  std::fill(frame.ignore.begin(), frame.ignore.end(), 1.f);
  for (const BlockLoss loss :
       {BlockLoss::SpecularMask, BlockLoss::TransmissionMask, BlockLoss::ObjectMask, BlockLoss::MonocularNormal}) {
    const LossResults there = results_of_blocks(frame, true, loss, 0);
    EXPECT_EQ(there.total, 0);
    for (const auto& plane : there.planes)
      for (const float g : plane) ASSERT_EQ(g, 0.f);
  }
}

// Depths that no neighbour continues, and pixels that show nothing, have no slope.
TEST(LossBlocks, NormalConsistencySkipsPixelsWithoutDepth) {
  TestFrame frame(21, 17, false);
  for (size_t i = 0; i < frame.raster.plane(Aov::Alpha).size(); i += 7) {
    frame.raster.plane(Aov::Alpha)[i] = 0.1f;
    frame.raster.plane(Aov::ZDepth)[i] = 0.2f;
  }
  const LossResults cpu = results_of_cpu(frame, true, "normal_consistency");
  const LossResults there = results_of_blocks(frame, true, BlockLoss::NormalConsistency, 0);
  EXPECT_GT(cpu.term, 0);
  EXPECT_NEAR(there.term, cpu.term, 3e-6 * cpu.term);
  for (const Aov a : {Aov::Normal, Aov::ZDepth, Aov::Alpha})
    EXPECT_GT(expect_near(there.planes[size_t(a)], cpu.planes[size_t(a)], 2e-5), 0);
}

}  // namespace
}  // namespace vitrine
