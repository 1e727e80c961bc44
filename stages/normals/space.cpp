#include "stages/normals/space.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

constexpr double kWorstAngle = 40;  // degrees
constexpr double kClearLead = 6;    // degrees to the second best frame
constexpr double kMostFace = 0.9;   // in the right frame nearly all normals face the camera
constexpr float kSure = 0.4f;       // minimum confidence of a geometric normal used for comparison
constexpr size_t kFewestPixels = 300;

struct Named {
  std::string_view name;
  NormalSpace space;
};
constexpr Named kNamed[] = {{"camera-opencv", {{1, 1, 1}, false}},
                            {"camera-opengl", {{1, -1, -1}, false}},
                            {"camera-left-up-back", {{-1, -1, -1}, false}},
                            {"world", {{1, 1, 1}, true}}};

}  // namespace

Vec3f NormalSpace::in_camera(const Vec3f& n, const Rigid& cam_from_world) const {
  return world ? cast<float>(cam_from_world.rotation * cast<double>(n)) : hadamard(signs, n);
}

std::string NormalSpace::name() const {
  for (const Named& named : kNamed)
    if (named.space.signs == signs && named.space.world == world) return std::string(named.name);
  const auto sign = [](float s) { return s < 0 ? '-' : '+'; };
  return fmt::format("camera, axes x{} y{} z{}", sign(signs.x), sign(signs.y), sign(signs.z));
}

std::vector<std::string> normal_space_names() {
  std::vector<std::string> names;
  for (const Named& named : kNamed) names.emplace_back(named.name);
  return names;
}

NormalSpace normal_space(std::string_view name) {
  for (const Named& named : kNamed)
    if (named.name == name) return named.space;
  VITRINE_CHECK(false, "'{}' passed the list of choices", name);
  return {};
}

void to_camera(NormalMap& map, const NormalSpace& space, const Rigid& cam_from_world) {
  for (int y = 0; y < map.normal.height(); ++y)
    for (int x = 0; x < map.normal.width(); ++x) {
      const Vec3f n = space.in_camera(map.at(x, y), cam_from_world);
      float* p = map.normal.pixel(x, y);
      p[0] = n.x, p[1] = n.y, p[2] = n.z;
    }
}

std::vector<SpaceCandidate> detected_space(std::span<const SpaceSample> samples, const std::string& what) {
  std::vector<SpaceCandidate> candidates;
  for (int bits = 0; bits < 8; ++bits)
    candidates.push_back({.space = {{bits & 1 ? -1.f : 1.f, bits & 2 ? -1.f : 1.f, bits & 4 ? -1.f : 1.f}, false}});
  candidates.push_back({.space = {{1, 1, 1}, true}});
  size_t pixels = 0;
  for (SpaceCandidate& c : candidates) {
    size_t compared = 0, facing = 0;
    double sum = 0;
    for (const SpaceSample& s : samples)
      for (int y = 0; y < s.given.normal.height(); ++y)
        for (int x = 0; x < s.given.normal.width(); ++x) {
          const Vec3f given = s.given.at(x, y), truth = s.geometric.at(x, y);
          if (squared_length(given) == 0 || squared_length(truth) == 0 || s.geometric.confidence.at(x, y) < kSure) continue;
          const Vec3f n = c.space.in_camera(given, s.view.cam_from_world);
          ++compared;
          sum += std::acos(std::clamp(double(dot(n, truth)), -1.0, 1.0));
          facing += dot(n, cast<float>(s.view.intrinsics.ray(x + 0.5, y + 0.5))) < 0;
        }
    pixels = compared;
    c.error_deg = compared > 0 ? sum / double(compared) * 180 / std::numbers::pi : 180;
    c.facing = compared > 0 ? double(facing) / double(compared) : 0;
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const SpaceCandidate& a, const SpaceCandidate& b) { return a.error_deg < b.error_deg; });
  const SpaceCandidate &best = candidates[0], &second = candidates[1];
  std::string why;
  if (pixels < kFewestPixels)
    why = fmt::format("only {} pixels have a normal from the photos' geometry to compare with", pixels);
  else if (best.error_deg > kWorstAngle)
    why = fmt::format("the best of 9 frames, {}, is still {:.0f} degrees off the photos' geometry on average", best.space.name(),
                      best.error_deg);
  else if (best.facing < kMostFace)
    why = fmt::format("in the best frame, {}, only {:.0f} % of the normals look at the camera", best.space.name(),
                      100 * best.facing);
  else if (second.error_deg < kClearLead + 1.1 * best.error_deg)
    why = fmt::format("{} ({:.0f} degrees off) and {} ({:.0f}) fit alike", best.space.name(), best.error_deg, second.space.name(),
                      second.error_deg);
  if (!why.empty())
    throw Error(ErrorKind::Input, "the frame of the normals is ambiguous",
                {.where = what,
                 .why = why,
                 .hint = fmt::format("name it: --set normals.files.space= (or normals.onnx.space=) one of {}",
                                     fmt::join(normal_space_names(), ", ")),
                 .code = "AMBIGUOUS_NORMAL_SPACE"});
  return candidates;
}

}  // namespace vitrine
