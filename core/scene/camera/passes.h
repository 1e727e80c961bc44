// Capture passes, sfm/passes.json of an sfm artifact: groups of photos between which the object was moved relative to its
// surroundings (for example turned over), and the reference frame of the poses.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vitrine {

using Passes = std::vector<std::vector<std::string>>;  // photo names, largest pass first

enum class PosesOf {
  Object,       // the object is fixed; the surroundings move between passes
  LargestPass,  // only photos of the largest pass have poses: the passes share too few object features
  Surroundings  // surroundings or object, unknown without masks; the other one moves between passes
};

// Passes between which the surroundings moved relative to the poses. Empty if there are none or the poses do not follow the
// object. Throws Error{Input} if the file is damaged.
Passes read_passes(const std::filesystem::path& sfm_artifact);
void write_passes(const std::filesystem::path& sfm_artifact, const Passes& passes, PosesOf poses);

// Sentence for the user; empty if there are no passes.
std::string passes_summary(const std::filesystem::path& sfm_artifact);
// Index of the pass that contains the photo; 0 without passes, passes.size() if not found.
size_t pass_of(const Passes& passes, const std::string& photo);

// "2 passes: 34 and 18 photos"
std::string passes_text(const Passes& passes);

}  // namespace vitrine
