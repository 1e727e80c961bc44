#include "core/learn/optim/adam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/learn/optim/rates.h"

namespace vitrine {
namespace {

SplatLayer random_layer(size_t size, uint64_t seed) {
  SplatLayer layer(LayerKind::Diffuse, 1, size);
  Rng rng(seed);
  for (const AttributeRow& r : kAttributes)
    for (float& v : layer.values(r.id)) v = rng.normal();
  return layer;
}

AttributeRates some_rates() {
  AttributeRates rates{};
  for (size_t a = 0; a < kAttributeCount; ++a) rates[a] = 0.01f * float(a + 1);
  return rates;
}

TEST(Adam, MatchesAPlainDoubleOneWithGapsInTheActivity) {
  const size_t n = 300;
  SplatLayer layer = random_layer(n, 1);
  Adam adam(layer);
  const AttributeRates rates = some_rates();
  struct Plain {
    double x, m = 0, v = 0;
  };
  std::vector<std::vector<Plain>> plain(kAttributeCount);
  for (const AttributeRow& r : kAttributes)
    for (float v : layer.values(r.id)) plain[size_t(r.id)].push_back({v});
  std::vector<int> steps(n, 0);
  double worst = 0;
  for (uint64_t step = 0; step < 40; ++step) {
    const SplatLayer grad = random_layer(n, 100 + step);
    std::vector<uint8_t> active(n);
    Rng rng(9, step);
    for (auto& a : active) a = rng.uniform() < 0.7f;
    EXPECT_EQ(adam.step(grad, rates, active, layer), 0u);
    for (size_t i = 0; i < n; ++i) {
      if (!active[i]) continue;
      ++steps[i];
      for (const AttributeRow& r : kAttributes)
        for (size_t c = 0, w = layer.width(r.id); c < w; ++c) {
          Plain& p = plain[size_t(r.id)][i * w + c];
          const double g = grad.at(r.id, i)[c];
          p.m = 0.9 * p.m + 0.1 * g;
          p.v = 0.999 * p.v + 0.001 * g * g;
          const double m = p.m / (1 - std::pow(0.9, steps[i])), v = p.v / (1 - std::pow(0.999, steps[i]));
          p.x -= rates[size_t(r.id)] * m / (std::sqrt(v) + 1e-15);
        }
    }
  }
  for (const AttributeRow& r : kAttributes)
    for (size_t k = 0; k < plain[size_t(r.id)].size(); ++k)
      worst = std::max(worst, std::abs(plain[size_t(r.id)][k].x - layer.values(r.id)[k]));
  EXPECT_LT(worst, 2e-5);  // worst seen 4e-6
}

TEST(Adam, LeavesInactiveSurfelsAndUntrainedAttributesAlone) {
  SplatLayer layer = random_layer(10, 1);
  const SplatLayer before = layer;
  Adam adam(layer);
  std::vector<uint8_t> active(10, 0);
  active[3] = 1;
  adam.step(random_layer(10, 2), some_rates(), active, layer);
  for (size_t i = 0; i < 10; ++i)
    for (const AttributeRow& r : kAttributes) {
      const bool trained = some_rates()[size_t(r.id)] > 0;
      EXPECT_EQ(layer.at(r.id, i)[0] == before.at(r.id, i)[0], i != 3 || !trained) << r.name << " of " << i;
    }
}

TEST(Adam, SkipsAndCountsSurfelsWithBrokenGradients) {
  for (float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                    -std::numeric_limits<float>::infinity()}) {
    SplatLayer layer = random_layer(600, 1), grad = random_layer(600, 2);
    const SplatLayer before = layer;
    Adam adam(layer);
    grad.at(Attribute::Rotation, 5)[2] = bad;
    grad.at(Attribute::ShRest, 599)[8] = bad;
    const std::vector<uint8_t> active(600, 1);
    EXPECT_EQ(adam.step(grad, some_rates(), active, layer), 2u);
    EXPECT_EQ(*layer.at(Attribute::Mean, 5), *before.at(Attribute::Mean, 5));
    EXPECT_EQ(*layer.at(Attribute::Mean, 599), *before.at(Attribute::Mean, 599));
    EXPECT_NE(*layer.at(Attribute::Mean, 6), *before.at(Attribute::Mean, 6));
    EXPECT_EQ(adam.step(random_layer(600, 3), some_rates(), active, layer), 0u);  // no poison stayed in the moments
    for (const AttributeRow& r : kAttributes)
      for (float v : layer.values(r.id)) ASSERT_TRUE(std::isfinite(v));
  }
}

TEST(Adam, SameBitsForAnyNumberOfThreadsAndAfterAnArchive) {
  const auto run = [](int threads, bool archived) {
    set_thread_limit(threads);
    SplatLayer layer = random_layer(2000, 1);
    Adam adam(layer);
    const std::vector<uint8_t> active(2000, 1);
    for (uint64_t s = 0; s < 6; ++s) {
      adam.step(random_layer(2000, 10 + s), some_rates(), active, layer);
      if (!archived || s != 2) continue;
      Archive out;
      out.layer(layer);
      adam.transfer(out);
      Archive in(out.bytes());
      SplatLayer restored;
      in.layer(restored);
      layer = restored;
      adam = Adam(layer);
      adam.transfer(in);
      EXPECT_TRUE(in.at_end());
    }
    set_thread_limit(0);
    return layer;
  };
  const SplatLayer reference = run(1, false);
  EXPECT_EQ(run(2, false), reference);
  EXPECT_EQ(run(7, true), reference);
}

TEST(Archive, DamageIsAnErrorAtEveryLength) {
  Archive out;
  SplatLayer written = random_layer(3, 1);
  out.layer(written);
  for (size_t size = 0; size < out.bytes().size(); ++size) {
    const std::string cut = out.bytes().substr(0, size);
    Archive in(cut);
    SplatLayer layer;
    EXPECT_THROW(in.layer(layer), Error) << size;
  }
}

TEST(KeepSurfels, MovesTheKeptToTheFront) {
  SplatLayer layer = random_layer(6, 1);
  const SplatLayer before = layer;
  const std::vector<uint32_t> kept{1, 2, 5};
  keep_surfels(layer, kept);
  ASSERT_EQ(layer.size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(layer.at(Attribute::ShDc, i)[1], before.at(Attribute::ShDc, kept[i])[1]);
}

TEST(Rates, MeanDecaysInUnitsOfTheRadius) {
  RatesConfig config;
  const auto mean = static_cast<size_t>(Attribute::Mean), opacity = static_cast<size_t>(Attribute::Opacity);
  config.mean_end_factor = 0.01;
  EXPECT_FLOAT_EQ(rates_at(config, 0, 2.5)[mean], 2.5f * config.rate[mean]);
  EXPECT_FLOAT_EQ(rates_at(config, 0.5, 1)[mean], 0.1f * config.rate[mean]);
  EXPECT_FLOAT_EQ(rates_at(config, 1, 1)[mean], 0.01f * config.rate[mean]);
  EXPECT_FLOAT_EQ(rates_at(config, 1, 7)[opacity], config.rate[opacity]);
}

TEST(Adam, FactorsScaleStepsAndThoseOfShapeLeaveAppearanceAlone) {
  const SplatLayer start = random_layer(3, 1), grad = random_layer(3, 2);
  const std::vector<uint8_t> active(3, 1);
  SplatLayer plain = start, scaled = start;
  Adam(start).step(grad, some_rates(), active, plain);
  const std::vector<float> all{1, 2, 3}, shape{1, 0.5f, 0};
  Adam(start).step(grad, some_rates(), active, scaled, {.all = all, .shape = shape});
  for (const AttributeRow& r : kAttributes) {
    const bool is_shape =
        r.id == Attribute::Mean || r.id == Attribute::Rotation || r.id == Attribute::LogScale || r.id == Attribute::Opacity;
    for (size_t i = 0; i < 3; ++i)
      for (size_t c = 0; c < start.width(r.id); ++c) {
        const float factor = all[i] * (is_shape ? shape[i] : 1), step = plain.at(r.id, i)[c] - start.at(r.id, i)[c];
        EXPECT_NEAR(scaled.at(r.id, i)[c] - start.at(r.id, i)[c], factor * step, 1e-6) << r.name;
        EXPECT_NE(step, 0);
      }
  }
}

}  // namespace
}  // namespace vitrine
