#include "stages/sfm/photo_gains.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/scene/image/exr.h"
#include "stages/sfm/gains/gains.h"
#include "stages/stage.h"

namespace vitrine {

namespace {

// What was exposed at once.
struct Exposure {
  std::string photo;
  std::optional<double> log_exposure;  // log(gain) from EXIF, up to a constant
};

struct Exposures {
  std::vector<Exposure> list;
  std::vector<uint32_t> of_image;  // [image of the model]
};

Exposures exposures_of(const ColmapModel& model, const std::vector<Photo>& photos) {
  std::map<std::string, const Photo*> photo_of;
  for (const Photo& p : photos) photo_of[p.name] = &p;
  Exposures out;
  std::map<std::string, uint32_t> index;
  for (const ColmapImage& image : model.images) {
    const auto found = photo_of.find(image.name);
    const Photo* photo = found == photo_of.end() ? nullptr : found->second;
    const std::string name = photo != nullptr && photo->rig ? photo->rig->panorama : image.name;
    const auto [at, is_new] = index.try_emplace(name, uint32_t(out.list.size()));
    out.of_image.push_back(at->second);
    if (!is_new) continue;
    const bool known = photo != nullptr && photo->exposure_ev;
    out.list.push_back({name, known ? std::optional(-std::numbers::ln2 * *photo->exposure_ev) : std::nullopt});
  }
  return out;
}

}  // namespace

Gains photo_gains(const ColmapModel& model, const std::vector<Photo>& photos, const fs::path& output, StageContext& context) {
  std::vector<GainSample> samples = track_samples(model, [&](const ColmapImage& image) {
    return read_exr_rgb(output / "linear" / fs::path(image.name).replace_extension(".exr"));
  });
  const Exposures exposures = exposures_of(model, photos);
  for (GainSample& s : samples) s.view = exposures.of_image[s.view];
  std::vector<std::optional<double>> log_exposures;
  for (const Exposure& e : exposures.list) log_exposures.push_back(e.log_exposure);
  const GainSolution solution = solve_gains(exposures.list.size(), model.points.size(), samples, {}, log_exposures);
  Gains gains;
  double low = 1, high = 1;
  for (size_t v = 0; v < model.images.size(); ++v) {
    const Vec3d& gain = gains[model.images[v].name] = solution.gains[exposures.of_image[v]];
    low = std::min({low, gain.x, gain.y, gain.z});
    high = std::max({high, gain.x, gain.y, gain.z});
  }
  for (uint32_t v : solution.undetermined)
    context.warning("SFM_GAIN_UNKNOWN",
                    fmt::format("{}: too few track colours to tell its exposure: it is that of EXIF, or the average",
                                exposures.list[v].photo));
  if (solution.fixed_exposure) log_info("sfm: the photos agree in exposure and white balance: all gains are 1");
  context.metric("gain_lowest", low);
  context.metric("gain_highest", high);
  context.metric("gain_spread", solution.spread);
  return gains;
}

}  // namespace vitrine
