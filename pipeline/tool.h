// A program that works on a project's artifacts outside of `vitrine run`: render, relight, edit, and the export stage with other
// options. They are started with the current artifacts, keep their own in the project's store, and tell their own errors.
#pragma once

#include <string>
#include <vector>

#include "core/artifact/manifest.h"
#include "core/base/file.h"
#include "pipeline/commands.h"

namespace vitrine {

struct ToolInputs {
  std::vector<std::string> stages;         // whose artifacts it reads
  std::vector<std::string> optional = {};  // the same, where they are there
  std::string missing;                     // what is told when one of `stages` was not computed: "there is no trained scene yet"
  fs::path edited = {};                    // stands for optimize, refine, mesh and decompose, unless empty (edited_scene)
};
// Program, store and inputs: what a call of the tool begins with. Throws Error when one is not there.
Words tool_call(const std::string& tool, const fs::path& project, const ToolInputs& inputs);

struct ToolResult {
  int exit_code = 0;  // the program has told why
  std::string key = {};
  Manifest manifest = {};
  fs::path entry = {};  // its artifact
};
ToolResult run_tool(const std::string& tool, const fs::path& project, const Words& call, const Words& how = {});

// The scene with the edits of PROJECT/edited/edits.yaml, or of `edits`, applied to the current artifacts (a look into the store
// when nothing changed) and linked into PROJECT/edited. Its folder in the store is a folder for ToolInputs::edited; empty when
// the program failed, with the exit code. The project must be locked.
struct EditedScene {
  int exit_code = 0;
  fs::path folder = {};
};
EditedScene edited_scene(const fs::path& project, const fs::path& edits, const Words& how);
inline fs::path edited_folder(const fs::path& project) { return project / "edited"; }

// Runs a program that prints for itself; its exit code.
int run_and_tell(const Words& words);
fs::path tool_program(const std::string& tool);

}  // namespace vitrine
