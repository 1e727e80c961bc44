// Descent of the numbers of a medium: finds those of a picture whose clear radiances are known, and keeps what it must keep.
#include "core/learn/trainer/medium_training.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vitrine {
namespace {

const MediumCoefficients<double> kTruth{{0.5, 0.2, 0.3}, {0.4, 0.3, 0.3}, {0.1, 0.3, 0.2}};

// Gradient of a mean squared error over known radiances and distances.
MediumCoefficients<double> gradient(const MediumCoefficients<double>& m, const MediumCoefficients<double>& truth) {
  MediumCoefficients<double> grad;
  constexpr double kRadiances[] = {0.02, 0.3, 0.9}, kDistances[] = {0.3, 1, 2.5, 6};
  for (const double clear : kRadiances)
    for (const double z : kDistances)
      for (size_t c = 0; c < 3; ++c) {
        const double wanted = seen_through_medium(clear, z, 1.0, truth.direct[c], truth.backscatter[c], truth.veil[c]);
        const double seen = seen_through_medium(clear, z, 1.0, m.direct[c], m.backscatter[c], m.veil[c]);
        const auto g = seen_through_medium_vjp(clear, z, 1.0, m.direct[c], m.backscatter[c], m.veil[c], (seen - wanted) / 12);
        grad.direct[c] += g.direct;
        grad.backscatter[c] += g.backscatter;
        grad.veil[c] += g.veil;
      }
  return grad;
}

MediumTraining trained(MediumKind kind, const MediumCoefficients<double>& start, const MediumCoefficients<double>& truth) {
  MediumTraining training(kind, start);
  for (int step = 0; step < 1500; ++step) training.descend(gradient(training.coefficients(), truth), 4e-3);
  return training;
}

TEST(MediumTraining, FindsTheNineNumbersOfWater) {
  const MediumCoefficients<double> start{{0.3, 0.3, 0.3}, {0.3, 0.3, 0.3}, {0.2, 0.2, 0.2}};
  const MediumCoefficients<double> found = trained(MediumKind::Water, start, kTruth).coefficients();
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(found.direct[c] / kTruth.direct[c], 1, 0.05) << c;
    for (const double z : {0.5, 2.0, 6.0})  // b_B and B compensate each other where distances are short
      EXPECT_NEAR(seen_through_medium(0.0, z, 1.0, found.direct[c], found.backscatter[c], found.veil[c]),
                  seen_through_medium(0.0, z, 1.0, kTruth.direct[c], kTruth.backscatter[c], kTruth.veil[c]), 0.01)
          << c << " " << z;
  }
}

TEST(MediumTraining, HazeKeepsOneCoefficient) {
  const MediumCoefficients<double> haze{{0.4, 0.4, 0.4}, {0.4, 0.4, 0.4}, {0.5, 0.55, 0.6}};
  const MediumCoefficients<double> start{{0.2, 0.2, 0.2}, {0.2, 0.2, 0.2}, {0.4, 0.4, 0.4}};
  const MediumCoefficients<double> found = trained(MediumKind::Haze, start, haze).coefficients();
  EXPECT_NEAR(found.direct.x, 0.4, 0.02);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(found.direct[c], found.direct.x);
    EXPECT_EQ(found.backscatter[c], found.direct.x);
    EXPECT_NEAR(found.veil[c], haze.veil[c], 0.03);
  }
}

TEST(MediumTraining, BrokenGradientsAreSkippedAndStatesComeBack) {
  MediumTraining training(MediumKind::Water, kTruth);
  MediumCoefficients<double> bad;
  bad.veil.y = std::nan("");
  training.descend(bad, 1e-2);
  EXPECT_EQ(training.coefficients().direct, kTruth.direct);
  training.descend({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, 1e-2);
  EXPECT_LT(training.coefficients().direct.x, kTruth.direct.x);
  Archive writer;
  training.transfer(writer);
  Archive reader(writer.bytes());
  MediumTraining back;
  back.transfer(reader);
  EXPECT_TRUE(reader.at_end());
  for (MediumTraining* t : {&training, &back}) t->descend({{-1, 2, 1}, {0, 1, 3}, {1, -1, 1}}, 1e-2);
  EXPECT_EQ(back.coefficients().direct, training.coefficients().direct);
  EXPECT_EQ(back.coefficients().veil, training.coefficients().veil);
}

}  // namespace
}  // namespace vitrine
