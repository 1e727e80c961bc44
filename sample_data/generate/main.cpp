// vitrine-generate SCENE -o DIR: writes the photos and the truth of one analytic scene.
#include <cstdio>
#include <iostream>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/config/cli.h"
#include "sample_data/generate/fisheyes.h"
#include "sample_data/generate/guest.h"
#include "sample_data/generate/panoramas.h"
#include "sample_data/generate/scenes/scenes.h"
#include "sample_data/generate/truth.h"

int main(int argc, char** argv) {
  using namespace vitrine;
  using namespace vitrine::generate;
  std::string folder, size, only, camera, medium, place = "0,0,0,1";
  int views = 0, threads = 0, seed = 0, guest = 0;
  bool help = false, bracket = false;
  GenerateDesc desc;
  std::string names;
  for (const SceneEntry& entry : scene_list()) names += std::string(names.empty() ? "" : ", ") + entry.name;
  CommandLine cli("vitrine-generate", "SCENE -o DIR", "Photos and truth of an analytic scene, path traced: " + names + ".");
  cli.value("output", 'o', "DIR", folder, "Folder for photos/ and truth/.");
  cli.flag("full-truth", 0, desc.full_truth, "Every truth picture at photo size, for every view.");
  cli.value("only", 0, "geometry|photos|relit", only, "One step of the three.");
  cli.value("spp", 0, "N", desc.samples, 1, "Samples of a pixel; the scene's own number when not given.");
  cli.value("views", 0, "N", views, 1, "Only the first N views.");
  cli.value("size", 0, "WxH", size, "Instead of the scene's picture size.");
  cli.value("camera", 0, "pinhole|equirect|fisheye", camera,
            "At the places of the views, equirect: 360-degree panoramas, --size WxH is 2:1; fisheye: photos of 180 degrees, with "
            "poses in poses/.");
  cli.value("threads", 'j', "N", threads, 0, "Threads; 0 = all.");
  cli.value("seed", 0, "N", seed, 1, "Which scene of the family; the three galleries need it, nothing else takes it.");
  cli.value("medium", 0, "coastal|deep|green|haze", medium,
            "Water or haze before the cameras; truth/clear has the views in air.");
  cli.value("guest", 0, "N", guest, 1, "Also the objects of seed N of the family; truth/mask/object shows them alone.");
  cli.value("guest-place", 0, "X,Y,DEGREES,SCALE", place,
            "Where the guest's origin stands: metres in the scene, turned about the vertical, scaled.");
  cli.flag("bracket", 0, bracket, "Exposure (+-1.5 EV) and white balance (+-800 K) of its own for each photo.");
  cli.flag("help", 'h', help, "Print this text.");
  try {
    const std::vector<std::string> scenes = cli.parse(std::vector<std::string>(argv + 1, argv + argc));
    if (help) {
      std::cout << cli.help();
      return 0;
    }
    if (scenes.size() != 1 || folder.empty())
      throw Error(ErrorKind::Usage, "a scene and an output folder are needed",
                  {.hint = "vitrine-generate tiny_room -o DIR; scenes: " + names, .code = "USAGE"});
    if (!only.empty() && only != "geometry" && only != "photos" && only != "relit")
      throw Error(ErrorKind::Usage, "--only takes geometry, photos or relit", {.where = only, .code = "USAGE"});
    set_log_console(LogLevel::Info, true);
    set_thread_limit(threads);
    desc.geometry = only.empty() || only == "geometry";
    desc.photos = only.empty() || only == "photos";
    desc.relit = only.empty() || only == "relit";
    Scene scene = scene_named(scenes[0], seed > 0 ? std::optional<uint64_t>(static_cast<uint64_t>(seed)) : std::nullopt);
    if (guest > 0) add_guest(scene, scene_named(scenes[0], uint64_t(guest)), guest_place(place));
    if (views > 0 && static_cast<size_t>(views) < scene.views.size()) scene.views.resize(static_cast<size_t>(views));
    if (!size.empty()) {
      int w = 0, h = 0, end = 0;
      if (std::sscanf(size.c_str(), "%dx%d%n", &w, &h, &end) != 2 || static_cast<size_t>(end) != size.size() || w < 8 || h < 8 ||
          w > 16384 || h > 16384)
        throw Error(ErrorKind::Usage, "--size is not WIDTHxHEIGHT", {.where = size, .hint = "for example --size 640x480"});
      resize_views(scene, w, h);
    }
    if (bracket) bracket_gains(scene);
    if (!medium.empty()) scene.medium = medium_named(medium);
    if (camera_kind(camera) == CameraKind::Equirect) {
      const Intrinsics& k = scene.views.front().intrinsics;
      if (!size.empty() && k.width != 2 * k.height)
        throw Error(ErrorKind::Usage, "panoramas are twice as wide as high",
                    {.where = size, .hint = "for example --size 1024x512", .code = "USAGE"});
      replace_by_panoramas(scene, size.empty() ? 0 : k.width);
    }
    if (camera_kind(camera) == CameraKind::Fisheye) {
      const Intrinsics k = scene.views.front().intrinsics;
      replace_by_fisheyes(scene, k.width, k.height);
    }
    generate::generate(scene, folder, desc);
  } catch (const Error& error) {
    log_error("{}", error.what());
    return exit_code(error.kind());
  }
  return 0;
}
