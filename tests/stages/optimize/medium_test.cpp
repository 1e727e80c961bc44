// Scenes photographed through water or haze: the fit before training, the choice of a medium, and a whole run.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/json.h"
#include "core/foundation/base/rng.h"
#include "core/render/picture/trained_scene.h"
#include "stages/optimize/medium_fit.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

using testing::TestContext;

const MediumCoefficients<double> kWater{{0.6, 0.2, 0.1}, {0.5, 0.25, 0.15}, {0.05, 0.2, 0.3}};
const MediumCoefficients<double> kHaze{{0.4, 0.4, 0.4}, {0.4, 0.4, 0.4}, {0.5, 0.55, 0.6}};

// Points of random colours in six of twelve photos at random distances, with noise and a twentieth of wrong colours.
std::vector<MediumSample> samples_in(const std::optional<MediumCoefficients<double>>& m, size_t points) {
  std::vector<MediumSample> out;
  for (uint32_t p = 0; p < points; ++p) {
    Rng rng(3, p);
    const Vec3d clear{rng.uniform_double(), rng.uniform_double(), rng.uniform_double()};
    for (uint32_t i = 0; i < 6; ++i) {
      MediumSample s{.point = p, .photo = (p + 2 * i) % 12, .distance = 0.6f + 1.4f * rng.uniform(), .linear = {}};
      for (size_t c = 0; c < 3; ++c) {
        const double z = double(s.distance);
        const double seen = m ? seen_through_medium(clear[c], z, 1.0, m->direct[c], m->backscatter[c], m->veil[c]) : clear[c];
        s.linear[c] = float(std::max(0.0, seen + 0.01 * double(rng.normal())));
      }
      if (rng.below(20) == 0) s.linear = {rng.uniform(), rng.uniform(), rng.uniform()};
      out.push_back(s);
    }
  }
  return out;
}

TEST(MediumFit, FindsWaterFromColoursAtSeveralDistances) {
  const auto fit = fitted_medium(samples_in(kWater, 400), MediumKind::Water);
  ASSERT_TRUE(fit);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(fit->medium.direct[c], kWater.direct[c], 0.04) << c;
    EXPECT_NEAR(fit->medium.veil[c] * fit->medium.backscatter[c], kWater.veil[c] * kWater.backscatter[c], 0.015) << c;
  }
  EXPECT_GT(fit->gain, 0.4);
  EXPECT_EQ(fit->points, 400u);
}

TEST(MediumFit, FindsOneCoefficientOfHaze) {
  const auto fit = fitted_medium(samples_in(kHaze, 400), MediumKind::Haze);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->medium.direct.x, 0.4, 0.03);
  EXPECT_EQ(fit->medium.direct.x, fit->medium.backscatter.z);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(fit->medium.veil[c], kHaze.veil[c], 0.04);
}

// All points are near; what the medium adds to far surfaces is known from the darkest pixels alone.
TEST(MediumFit, DarkPixelsLimitTheBackscatterOfFarSurfaces) {
  std::vector<MediumSample> near_by = samples_in(kWater, 400);
  for (MediumSample& s : near_by) {
    const double z = double(s.distance), nearer = 0.6 + 0.2 * (z - 0.6);
    for (size_t c = 0; c < 3; ++c) {
      const double clear =
          (double(s.linear[c]) - kWater.veil[c] * (1 - std::exp(-kWater.backscatter[c] * z))) * std::exp(kWater.direct[c] * z);
      s.linear[c] = float(seen_through_medium(clear, nearer, 1.0, kWater.direct[c], kWater.backscatter[c], kWater.veil[c]));
    }
    s.distance = float(nearer);
  }
  const auto added = [](const MediumCoefficients<double>& m, size_t c, double z) {
    return m.veil[c] * (1 - std::exp(-m.backscatter[c] * z));
  };
  std::vector<DarkLevel> dark;
  for (const double z : {0.7, 2.0, 3.5})
    dark.push_back({{z, z, z}, {added(kWater, 0, z), added(kWater, 1, z), added(kWater, 2, z)}});
  const auto free = fitted_medium(near_by, MediumKind::Water), limited = fitted_medium(near_by, MediumKind::Water, dark);
  ASSERT_TRUE(free && limited);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_LE(added(limited->medium, c, 3.5), 1.001 * dark.back().linear[c] + 1e-3) << c;
    EXPECT_NEAR(limited->medium.direct[c], kWater.direct[c], 0.04) << c;
  }
  EXPECT_GT(added(free->medium, 2, 3.5), 1.05 * dark.back().linear.z);
}

TEST(MediumFit, ExplainsNothingInAir) {
  for (const MediumKind kind : {MediumKind::Water, MediumKind::Haze}) {
    const auto fit = fitted_medium(samples_in(std::nullopt, 400), kind);
    ASSERT_TRUE(fit);
    EXPECT_LT(fit->gain, 0.02);
    EXPECT_LT(fit->depth, 0.03);
  }
  EXPECT_FALSE(fitted_medium(samples_in(kWater, kFewestMediumPoints - 1), MediumKind::Water));
}

// The tiny scene photographed through a medium.
class TinyWater : public ::testing::Test {
 protected:
  void write(const std::optional<MediumCoefficients<double>>& medium) {
    ImageOptions image;
    image.medium = medium;
    testing::write_tiny_sfm(sfm(), 18, 48, 36, {.diffuse = testing::tiny_scene()}, image);
  }
  fs::path sfm() const { return folder_.path() / "sfm"; }
  fs::path work(const std::string& name) const { return folder_.path() / name; }

  OptimizeConfig config(WantedMedium medium, int iterations) const {
    OptimizeConfig c = testing::tiny_config(iterations);
    c.initial.stereo_side = 48;
    c.medium = medium;
    return c;
  }
  TemporaryFolder folder_;
};

TEST_F(TinyWater, InAirAutoStaysOffAndAWantedMediumIsAWarning) {
  write(std::nullopt);
  TestContext guessed(sfm(), work("guessed")), off(sfm(), work("off")), wanted(sfm(), work("wanted"));
  run_optimize(config(WantedMedium::Auto, 20), guessed);
  run_optimize(config(WantedMedium::Off, 20), off);
  EXPECT_TRUE(guessed.warnings.empty());
  for (const char* file : {"gaussians/diffuse.ply", "optimize/model.json"})
    EXPECT_EQ(read_file(guessed.output() / file), read_file(off.output() / file)) << file;
  run_optimize(config(WantedMedium::Haze, 20), wanted);
  EXPECT_EQ(wanted.warnings, std::vector<std::string>{"NO_MEDIUM"});
  EXPECT_FALSE(read_image_options(wanted.output() / "optimize/model.json").medium);
}

TEST_F(TinyWater, AKilledRunEndsWithTheSameBytes) {
  write(kHaze);
  TestContext whole(sfm(), work("whole"));
  run_optimize(config(WantedMedium::Haze, 40), whole);
  EXPECT_TRUE(whole.warnings.empty());
  const auto medium = read_image_options(whole.output() / "optimize/model.json").medium;
  ASSERT_TRUE(medium);
  EXPECT_GT(medium->direct.x, 0.2);
  OptimizeConfig often = config(WantedMedium::Haze, 40);
  often.checkpoint_every = 15;
  TestContext stopped(sfm(), work("stopped"));
  stopped.after_step = [](int step) {
    if (step == 33) throw testing::Stopped();
  };
  EXPECT_THROW(run_optimize(often, stopped), testing::Stopped);
  TestContext resumed(sfm(), work("stopped"));
  run_optimize(often, resumed);
  for (const char* file : {"gaussians/diffuse.ply", "optimize/model.json"})
    EXPECT_EQ(read_file(whole.output() / file), read_file(resumed.output() / file)) << file;
}

}  // namespace
}  // namespace vitrine
