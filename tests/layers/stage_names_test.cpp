// The pipeline knows the stages from their descriptions: no file of pipeline/ names one in a string literal ("optimize",
// "sfm/report.json", "sfm.turntable"), save those of the table below, each with its reason. A name that is gone must leave the
// table.
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

const fs::path kPipeline = fs::path(VITRINE_SOURCE_DIR) / "pipeline";

struct Exception {
  const char *file, *names, *why;
};

constexpr Exception kExceptions[] = {
    {"main.cpp", "inspect mark render relight view edit compose export", "words of the command line, not stages"},
    {"run_command.cpp", "masks objects normals", "flags --masks, --objects and --normals"},
    {"inspect_command.cpp", "masks", "flag --masks"},
    {"given_inputs.cpp", "masks", "the outside input that --masks gives; advice with options of the stage that reads it"},
    {"given_inputs.cpp", "objects", "the outside input that --objects gives, read before the stages run"},
    {"given_inputs.cpp", "sfm", "advice with its options, which an error about masks gives"},
    {"run_command.cpp", "decompose", "--grey-card is its option decompose.grey_card"},
    {"run_command.cpp", "ingest", "--frames is its option ingest.frames"},
    {"inspect_command.cpp", "ingest", "--frames is its option ingest.frames"},
    {"mark_command.cpp", "ingest", "frames of films: the copies that ingest has made"},
    {"run_command.cpp", "export", "--scale-bar is its option export.scale_bar"},
    {"measures_in_photos.cpp", "ingest sfm decompose export", "the same two options; size and cameras of the photos"},
    // Commands of one program each, and the results that the program reads.
    {"export_command.cpp", "export sfm optimize mesh refine decompose objects", "vitrine export"},
    {"project.h", "export", "export/, which a run and vitrine export share"},
    {"picture_commands.cpp", "render relight sfm optimize mesh decompose refine compose", "vitrine render, vitrine relight"},
    {"page_commands.cpp", "view", "vitrine view"},
    {"mark_command.cpp", "mark sfm masks", "vitrine mark: cameras and masks of an earlier run"},
    {"pages.cpp", "view sfm optimize refine mesh decompose masks objects", "vitrine view"},
    {"tool.cpp", "edit sfm optimize mesh refine decompose masks objects", "vitrine edit, and which results an edit replaces"},
    {"compose_command.cpp", "compose view sfm optimize mesh decompose masks objects", "vitrine compose: the artifacts it makes"},
    {"ct_command.cpp", "tomography", "vitrine ct"},
    {"farm/plan.cpp", "masks", "the folder masks/ next to photos"},
    {"farm/status.cpp", "view", "links to the pages of a run"},
    {"python/finished_run.cpp", "sfm optimize refine mesh decompose edit", "the artifacts of which a scene is made"},
    {"python/bind_objects.cpp", "objects mesh normals", "the table of objects and the mesh"},
    {"python/bind_scene.cpp", "objects mesh normals render relight", "names of methods"},
    {"python/bind_surfels.cpp", "normals", "name of a property"},
    {"python/bind_relighting.cpp", "render", "name of a method"},
    {"inspect_command.cpp", "mark", "advice: the command vitrine mark"},
    {"inspect_command.cpp", "inspect sfm", "vitrine inspect: cameras of an earlier run"},
    {"rehearsal.cpp", "ingest sfm", "vitrine inspect --poses: a run up to sfm on small copies of the photos"},
    // Results that are no figures.
    {"cost_model.cpp", "ingest", "number and sizes of the photos, in ingest/photos.json"},
    {"report_page/page.cpp", "mesh optimize", "a section of the page; the views that were held out"},
    {"report_page/regions.cpp", "normals", "pictures of the confidence"},
    {"report_page/sections_figures.cpp", "objects", "the rows of eval/metrics.json"},
    {"report_page/sections_pictures.cpp", "decompose masks mesh normals objects optimize",
     "the pictures of the page, and a section"},
    {"report_page/sections_run.cpp", "ingest", "copies of the photos"},
    {"report_page/verdict.cpp", "relight mark", "advice: the commands vitrine relight and vitrine mark"},
};

std::set<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::set<std::string> words;
  for (std::string word; in >> word;) words.insert(word);
  return words;
}

// Names behind set(VITRINE_STAGES ...) and set(VITRINE_TOOLS ...).
std::set<std::string> stage_names() {
  const std::string text = read_file(kPipeline.parent_path() / "stages/CMakeLists.txt");
  std::set<std::string> names;
  for (const char* list : {"VITRINE_STAGES", "VITRINE_TOOLS"}) {
    std::smatch m;
    if (std::regex_search(text, m, std::regex("set\\(" + std::string(list) + " ([a-z_ ]+)\\)"))) names.merge(words_of(m[1]));
  }
  return names;
}

// Stages that string literals of a source name: "mesh", or "mesh" before a slash or a full stop.
std::set<std::string> named_in(const std::string& source, const std::set<std::string>& stages) {
  static const std::regex comment("//[^\n]*"), literal("\"((?:[^\"\\\\\n]|\\\\.)*)\""), first("^([a-z_]+)(?:$|[/.]\\w)");
  const std::string code = std::regex_replace(source, comment, "");
  std::set<std::string> named;
  for (std::sregex_iterator l(code.begin(), code.end(), literal), end; l != end; ++l) {
    const std::string text = (*l)[1];
    std::smatch m;
    if (std::regex_search(text, m, first) && stages.contains(m[1])) named.insert(m[1]);
  }
  return named;
}

TEST(StageNames, AreFoundInLiteralsAndNotInComments) {
  const std::set<std::string> stages = stage_names();
  ASSERT_GE(stages.size(), 14u);
  const char* source = R"(f("mesh"); g("sfm/report.json", "optimize.iterations=3"); // "relight"
                          h("meshes", "a mesh", "refine: it", "\"export\""); #include "core/mesh/x.h")";
  EXPECT_EQ(named_in(source, stages), (std::set<std::string>{"mesh", "sfm", "optimize"}));
}

TEST(StageNames, StandInNoFileOfThePipelineButTheListedOnes) {
  std::map<std::string, std::set<std::string>> allowed;
  for (const Exception& e : kExceptions) allowed[e.file].merge(words_of(e.names));
  const std::set<std::string> stages = stage_names();
  size_t files = 0;
  for (const auto& e : fs::recursive_directory_iterator(kPipeline)) {
    if (e.path().extension() != ".h" && e.path().extension() != ".cpp") continue;
    ++files;
    const std::string file = fs::relative(e.path(), kPipeline).string();
    const std::set<std::string> named = named_in(read_file(e.path()), stages);
    for (const std::string& stage : named)
      EXPECT_TRUE(allowed[file].contains(stage))
          << "pipeline/" << file << " names the stage \"" << stage
          << "\": let the stage declare it (stages/README.md, \"A new stage\"), or list it in kExceptions with its reason";
    for (const std::string& stage : allowed[file])
      EXPECT_TRUE(named.contains(stage)) << "kExceptions: pipeline/" << file << " does not name \"" << stage << "\" any more";
    allowed.erase(file);
  }
  EXPECT_GT(files, 50u);
  for (const auto& [file, names] : allowed) ADD_FAILURE() << "kExceptions: there is no pipeline/" << file;
}

}  // namespace
}  // namespace vitrine
