#include "stages/inspect/given_masks.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/intake/depth/depth_files.h"

namespace vitrine {

namespace {

struct DepthFacts {
  bool read = false, other_shape = false;
  double known = 0;  // share of the pixels
  float nearest = 0, farthest = 0;
};

DepthFacts depth_facts_of(const std::filesystem::path& file, double unit, const PhotoFacts& photo) {
  const ImageF depth = read_depth(file, unit);
  DepthFacts facts{.read = true};
  if (!same_depth_shape(depth.width(), depth.height(), photo.width, photo.height)) {
    if (same_depth_shape(depth.width(), depth.height(), photo.height, photo.width))
      throw_wrong_depth_size(file, depth, photo.width, photo.height);
    facts.other_shape = true;
  }
  for (const float z : depth.data()) {
    if (!(z > 0)) continue;
    facts.known += 1.0 / double(depth.pixel_count());
    facts.nearest = facts.nearest > 0 ? std::min(facts.nearest, z) : z;
    facts.farthest = std::max(facts.farthest, z);
  }
  return facts;
}

void add_findings(const std::vector<DepthFacts>& facts, const std::vector<size_t>& usable, std::vector<Finding>& list) {
  std::vector<size_t> without, other;
  size_t maps = 0;
  double known = 0;
  float nearest = 0, farthest = 0;
  for (size_t i = 0; i < facts.size(); ++i) {
    if (!facts[i].read) without.push_back(usable[i]);
    if (facts[i].other_shape) other.push_back(usable[i]);
    if (!facts[i].read) continue;
    ++maps, known += facts[i].known;
    if (facts[i].nearest > 0) nearest = nearest > 0 ? std::min(nearest, facts[i].nearest) : facts[i].nearest;
    farthest = std::max(farthest, facts[i].farthest);
  }
  list.push_back({"depth_maps",
                  Severity::Note,
                  fmt::format("{} of {} photos have a depth map", maps, usable.size()),
                  fmt::format("{:.0f} % of the pixels are known, {:.3g} to {:.3g} m",
                              100 * known / double(std::max<size_t>(maps, 1)), nearest, farthest),
                  "their scale is solved with the points of sfm; where it cannot be, a run goes on without them",
                  {}});
  if (!without.empty())
    list.push_back({"DEPTH_INCOMPLETE", Severity::Warning,
                    fmt::format("{} of {} photos have no depth map", without.size(), usable.size()),
                    "maps are found by the names of the photos", "the other photos have depth from stereo alone", without});
  if (!other.empty())
    list.push_back({"DEPTH_OTHER_SHAPE", Severity::Warning,
                    fmt::format("{} depth maps have another shape than their photos", other.size()),
                    "they are used if they have the size of the undistorted photos, else the run ends there",
                    "give the maps of the photos as they were taken", other});
}

}  // namespace

std::vector<Finding> depth_findings(const std::filesystem::path& path, const std::vector<PhotoFacts>& photos) {
  std::vector<Finding> list;
  std::vector<size_t> usable;
  std::vector<std::string> names;
  for (size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].usable()) continue;
    usable.push_back(i);
    names.push_back(photos[i].name);
  }
  if (usable.empty()) return list;
  try {
    const DepthFolder folder(path);
    const auto files = folder.match(names);
    std::vector<DepthFacts> facts(usable.size());
    parallel_for(usable.size(), 1, [&](size_t i) {
      if (files[i] && interrupt_signal() == 0) facts[i] = depth_facts_of(*files[i], folder.unit(), photos[usable[i]]);
    });
    throw_if_interrupted();
    add_findings(facts, usable, list);
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    list.push_back(refused_input(e));
  }
  return list;
}

}  // namespace vitrine
