#include "tests/bench/optics/scenes.h"

#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/hash.h"

namespace vitrine {
namespace {

bool is_capture(const fs::path& folder) { return fs::is_directory(folder / "photos"); }

void require_whole(const OpticsScene& scene) {
  for (const char* part : {"photos", "truth/transforms.json"})
    if (!fs::exists(scene.folder / part))
      throw Error(ErrorKind::Input, "a scene is not whole",
                  {.where = (scene.folder / part).string(),
                   .why = "every scene needs photos/ and truth/ with transforms.json, masks, depth and normals",
                   .hint = "vitrine-generate gallery --seed N -o DIR; or remove the folder, then it is made anew",
                   .code = "BAD_SCENE"});
}

}  // namespace

std::vector<OpticsScene> optics_scenes(const std::vector<int>& seeds, const std::vector<fs::path>& places, const fs::path& made,
                                       const MakeScene& make) {
  std::vector<OpticsScene> scenes;
  for (const fs::path& place : places)
    if (!fs::is_directory(place))
      throw Error(ErrorKind::Input, "there is no such folder",
                  {.where = place.string(),
                   .hint = "--scenes takes folders with seed_<N>/, or captures with photos/ and truth/",
                   .code = "MISSING_INPUT"});
  for (const int seed : seeds) {
    const std::string name = fmt::format("seed_{}", seed);
    OpticsScene scene{name, made / name};
    for (const fs::path& place : places)
      if (fs::is_directory(place / name)) {
        scene.folder = place / name;
        break;
      }
    if (!fs::exists(scene.folder)) {
      const fs::path unfinished = made / (name + ".unfinished");
      fs::remove_all(unfinished);
      make_folders(made);
      make(seed, unfinished);
      fs::rename(unfinished, scene.folder);
    }
    scenes.push_back(std::move(scene));
  }
  for (const fs::path& place : places)
    if (is_capture(place)) {
      const fs::path folder = fs::absolute(place).lexically_normal();
      scenes.push_back({(folder.has_filename() ? folder : folder.parent_path()).filename().string(), folder});
    }
  if (scenes.empty())
    throw Error(ErrorKind::Usage, "there is no scene",
                {.hint = "--seeds 1-12, or --scenes DIR with photos/ and truth/", .code = "USAGE"});
  std::set<std::string> names;
  for (const OpticsScene& scene : scenes) {
    require_whole(scene);
    if (!names.insert(scene.name).second)
      throw Error(ErrorKind::Usage, fmt::format("two scenes are called '{}'", scene.name),
                  {.where = scene.folder.string(), .hint = "rename one of the folders", .code = "USAGE"});
  }
  return scenes;
}

std::string digest_of_training_inputs(const fs::path& scene) {
  Hasher hasher;
  hasher.add(digest_folder(scene / "photos").hex()).add(digest_file(scene / "truth/transforms.json").hex());
  if (fs::is_directory(scene / "truth/mask")) hasher.add(digest_folder(scene / "truth/mask").hex());
  return hasher.digest().short_hex();
}

std::string digest_of_truth(const fs::path& scene) { return digest_folder(scene / "truth").short_hex(); }

}  // namespace vitrine
