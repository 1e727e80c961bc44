// sfm/passes.json of an sfm artifact: groups of photos between which an object was moved against its surroundings, turned over
// for instance, and what the poses are relative to.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vitrine {

using Passes = std::vector<std::vector<std::string>>;  // names of photos, the largest pass first

enum class PosesOf {
  Object,       // what surrounds it stands elsewhere in each pass
  LargestPass,  // its photos alone have poses: they share too little of the object with the others
  Surroundings  // or the object: without masks nobody knows which; the other of both stands elsewhere in each pass
};

// The passes between which the surroundings of the object moved against the poses. Empty: there are none, or the poses do not
// follow the object. Throws Error{Input} for a file that is damaged.
Passes read_passes(const std::filesystem::path& sfm_artifact);
void write_passes(const std::filesystem::path& sfm_artifact, const Passes& passes, PosesOf poses);

// A sentence for people; empty where there are no passes.
std::string passes_summary(const std::filesystem::path& sfm_artifact);
// The pass that holds the photo; 0 where there are no passes, passes.size() where none of them does.
size_t pass_of(const Passes& passes, const std::string& photo);

// "2 passes: 34 and 18 photos"
std::string passes_text(const Passes& passes);

}  // namespace vitrine
