// What `vitrine render` and `vitrine relight` share: options of pictures, and a program beside the stages that is started with
// the project's artifacts, and whose own artifact is linked where the user wants to see it.
#pragma once

#include "core/base/file.h"
#include "core/config/cli.h"
#include "pipeline/commands.h"
#include "pipeline/tool_options.h"

namespace vitrine {

struct PictureArguments : ToolOptions {
  std::string output, views = "heldout", size;
  bool edited = false, force = false;
};
struct PictureTool {
  std::string name;                                       // "render": program vitrine-render, and its part of the store
  std::string folder;                                     // in which the pictures appear
  std::vector<std::string> stages;                        // whose artifacts it reads
  std::vector<std::string> optional_stages = {"refine"};  // likewise, where there are any
  std::string missing;                                    // "there is no trained scene yet"
  Words words;                                            // more arguments for the program
};
void add_picture_options(CommandLine& cli, PictureArguments& a, const PictureTool& tool);
// The project folder of the words that the command line left over, or the current folder.
fs::path picture_project(const Words& rest);
// --input NAME=PATH of a file that the user names. Throws Error{Input} when there is none.
void add_input_file(const std::string& name, const std::string& path, const std::string& hint, Words& words);
int run_picture_tool(const PictureTool& tool, const fs::path& project, const PictureArguments& a);

}  // namespace vitrine
