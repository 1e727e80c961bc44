// Shared by `vitrine render` and `vitrine relight`: picture options, and a program that runs on the project's artifacts and whose
// own artifact is linked into the output folder.
#pragma once

#include "core/foundation/base/file.h"
#include "core/foundation/config/cli.h"
#include "pipeline/commands.h"
#include "pipeline/tool_options.h"

namespace vitrine {

struct PictureArguments : ToolOptions {
  std::string output, views = "heldout", size;
  bool edited = false, force = false;
};
struct PictureTool {
  std::string name;                                       // "render": runs vitrine-render; also its folder in the store
  std::string folder;                                     // folder of the pictures
  std::vector<std::string> stages;                        // required artifacts
  std::vector<std::string> optional_stages = {"refine"};  // optional artifacts
  std::string missing;                                    // error message: "there is no trained scene yet"
  Words words;                                            // additional arguments of the program
};
void add_picture_options(CommandLine& cli, PictureArguments& a, const PictureTool& tool);
// The project folder among the remaining command-line words, or the current folder.
fs::path picture_project(const Words& rest);
// Adds --input NAME=PATH for a file of the user. Throws Error{Input} if it does not exist.
void add_input_file(const std::string& name, const std::string& path, const std::string& hint, Words& words);
int run_picture_tool(const PictureTool& tool, const fs::path& project, const PictureArguments& a);

}  // namespace vitrine
