// Stages and programs that had another name in the version before, whose names users' files and output folders may still have.
// The old names are accepted in this version, with a warning. One list for all who read names: the command line and files of a
// stage, of a run, and output folders.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/file.h"

namespace vitrine {

struct RenamedStage {
  std::string_view before, now;
  std::string_view folder;  // of its files in an artifact; that of before has the name of before
};
// In the order in which names become free: `relight` was the stage that is `decompose` now, and is the program that was `relit`.
inline constexpr RenamedStage kRenamedStages[] = {{"relight", "decompose", "decompose"}, {"relit", "relight", "relit"}};

// Empty: it has always been called so.
std::string_view stage_name_before(std::string_view now);
// Whether the name of before means another stage or program now.
bool is_name_of_another_now(std::string_view before);
// "'relight' is called 'decompose' now; the old name is accepted in this version alone"
std::string renamed_stage_message(std::string_view before, std::string_view now);

// Whether an output folder has results under names of the version before.
bool has_results_of_renamed_stages(const fs::path& project);
// Makes them the current artifacts of the new names: files are linked in the store and in the folder, with the key that the stage
// has now, so that nothing is computed again and nothing is lost (`vitrine cache prune` removes the old entries). Damaged ones
// are left out: they are computed anew. Returns one line for each. The caller holds the lock of the folder.
std::vector<std::string> adopt_results_of_renamed_stages(const fs::path& project);

}  // namespace vitrine
