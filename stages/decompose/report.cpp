#include "stages/decompose/report.h"

#include <algorithm>

namespace vitrine {

nlohmann::ordered_json report_of(const FoundLight& f) {
  using Json = nlohmann::ordered_json;
  const LightSolution& solution = f.solution;
  const bool card = !f.config.grey_card.empty();
  Json report{
      {"points",
       {{"all", f.points.size()},
        {"on_mesh", std::ranges::count(f.points, true, &LitPoint::inner)},
        {"usable", std::ranges::count(f.usable, true)},
        {"solved_with", f.solved_with},
        {"voxel", f.voxel}}},
      {"cells", {{"all", solution.light.size()}, {"solved", std::ranges::count(solution.free, true)}}},
      {"surroundings",
       {{"share_of_sphere", f.around.wall_share()},
        {"faces", f.shell_faces},
        {"sky_distance", f.sky_distance},
        {"continued_to_sine", f.walls.sine},
        {"mirrored_sky_from_sine", f.horizon ? Json(*f.horizon) : Json()}}},
      {"light_known_share", solution.known_share},
      {"misfit_log_rms", solution.misfit},
      {"scale",
       {{"by", card ? "grey_card" : "convention"},
        {"meaning", card ? fmt::format("the card has the albedo {}", f.config.grey_albedo)
                         : fmt::format("the open light is white in the mean, and the brightest twentieth of the surface has the "
                                       "albedo {}",
                                       f.config.white_albedo)},
        {"limited_by_bounced_light", solution.scale_by_bounces}}}};
  if (f.card_beside) report["scale"]["card"] = "in the photo, beside the trained scene";
  return report;
}

}  // namespace vitrine
