#include <fmt/format.h>

#include "stages/optimize/medium_fit.h"

namespace vitrine {

namespace {

// Of a medium that is wanted, and of one that is guessed: least gain and b_D z at the median distance. Two scenes in air gave up
// to 0.005 and 0.06, waters and haze in one scene 0.14 to 0.3 and 0.5 to 0.9 (EXPERIMENTS.md).
constexpr double kWantedGain = 0.02, kWantedDepth = 0.03;
constexpr double kGuessedGain = 0.05, kGuessedDepth = 0.1;
constexpr double kWaterOverHaze = 0.01;  // by how much more the nine numbers must explain

std::string described(const Vec3d& v) { return fmt::format("{:.3g} {:.3g} {:.3g}", v.x, v.y, v.z); }

std::string described(MediumKind kind, const MediumFit& fit) {
  return fmt::format(
      "{} between cameras and surfaces: b_D {}, b_B {}, B {}; explains {:.0f} % of the colour differences of {} points in "
      "left-out "
      "photos",
      kind == MediumKind::Water ? "water" : "haze", described(fit.medium.direct), described(fit.medium.backscatter),
      described(fit.medium.veil), 100 * fit.gain, fit.points);
}

}  // namespace

std::optional<ChosenMedium> chosen_medium(WantedMedium wanted, const Capture& capture, const Targets& targets,
                                          const std::function<const DenseDepth&()>& depth, uint64_t seed) {
  if (wanted == WantedMedium::Off) return std::nullopt;
  const std::vector<MediumSample> samples = medium_samples(capture, targets, depth(), seed);
  const std::vector<DarkLevel> dark = dark_levels(capture, targets, depth());
  const bool guessed = wanted == WantedMedium::Auto;
  MediumKind kind = wanted == WantedMedium::Water ? MediumKind::Water : MediumKind::Haze;
  std::optional<MediumFit> fit = fitted_medium(samples, kind, dark);
  if (!fit)
    return ChosenMedium{{},
                        fmt::format("no water or haze is removed: fewer than {} points are seen in three photos from different "
                                    "distances (more photos, nearer and farther ones)",
                                    kFewestMediumPoints)};
  if (guessed) {
    const std::optional<MediumFit> water = fitted_medium(samples, MediumKind::Water, dark);
    if (water->gain > fit->gain + kWaterOverHaze) kind = MediumKind::Water, fit = water;
  }
  const std::string found = described(kind, *fit);
  if (guessed && !(fit->gain >= kGuessedGain && fit->depth >= kGuessedDepth))
    return ChosenMedium{{}, fmt::format("no water or haze is removed; tried: {}", found)};
  if (!(fit->gain >= kWantedGain && fit->depth >= kWantedDepth))
    return ChosenMedium{{}, fmt::format("no water or haze is removed: colours do not change with the distance ({})", found)};
  return ChosenMedium{MediumStart{kind, fit->medium}, found};
}

}  // namespace vitrine
