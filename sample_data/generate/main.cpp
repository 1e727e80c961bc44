// vitrine-generate SCENE -o DIR: writes the photos and the truth of one analytic scene.
#include <cstdio>

#include <CLI/CLI.hpp>

#include "core/base/error.h"
#include "core/base/log.h"
#include "core/base/parallel.h"
#include "sample_data/generate/scenes/scenes.h"
#include "sample_data/generate/truth.h"

int main(int argc, char** argv) {
  using namespace vitrine;
  using namespace vitrine::generate;
  CLI::App app{"Photos and truth of an analytic scene, path traced"};
  std::string scene_name, folder, size;
  int views = 0, threads = 0;
  GenerateDesc desc;
  std::string names;
  for (const SceneEntry& entry : scene_list()) names += std::string(names.empty() ? "" : ", ") + entry.name;
  app.add_option("scene", scene_name, "one of: " + names)->required();
  app.add_option("-o,--output", folder, "folder for photos/ and truth/")->required();
  app.add_flag("--full-truth", desc.full_truth, "every truth picture at photo size, for every view");
  std::string only;
  app.add_option("--only", only, "one step of the three")->check(CLI::IsMember({"geometry", "photos", "relit"}));
  app.add_option("--spp", desc.samples, "samples a pixel (default: the scene's)")->check(CLI::Range(1, 65536));
  app.add_option("--views", views, "only the first N views")->check(CLI::Range(1, 100000));
  app.add_option("--size", size, "WxH instead of the scene's picture size");
  app.add_option("-j,--threads", threads, "0 = all")->check(CLI::Range(0, 4096));
  CLI11_PARSE(app, argc, argv);
  try {
    set_log_console(LogLevel::Info, true);
    set_thread_limit(threads);
    desc.geometry = only.empty() || only == "geometry";
    desc.photos = only.empty() || only == "photos";
    desc.relit = only.empty() || only == "relit";
    Scene scene = scene_named(scene_name);
    if (views > 0 && static_cast<size_t>(views) < scene.views.size()) scene.views.resize(static_cast<size_t>(views));
    if (!size.empty()) {
      int w = 0, h = 0, end = 0;
      if (std::sscanf(size.c_str(), "%dx%d%n", &w, &h, &end) != 2 || static_cast<size_t>(end) != size.size() || w < 8 || h < 8 ||
          w > 16384 || h > 16384)
        throw Error(ErrorKind::Usage, "--size is not WIDTHxHEIGHT", {.where = size, .hint = "for example --size 640x480"});
      resize_views(scene, w, h);
    }
    generate::generate(scene, folder, desc);
  } catch (const Error& error) {
    log_error("{}", error.what());
    return exit_code(error.kind());
  }
  return 0;
}
