// sfm/passes.json of an sfm artifact: groups of photos between which the object was moved against its surroundings, turned over
// for instance. The poses are those of the object. What surrounds it stands elsewhere in each pass.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace vitrine {

using Passes = std::vector<std::vector<std::string>>;  // names of photos, the largest pass first

// Empty: the artifact has no such file, the object did not move. Throws Error{Input} for a file that is damaged.
Passes read_passes(const std::filesystem::path& sfm_artifact);
void write_passes(const std::filesystem::path& sfm_artifact, const Passes& passes);

// "2 passes: 34 and 18 photos"
std::string passes_text(const Passes& passes);

}  // namespace vitrine
