#include "sample_data/generate/scenes/scenes.h"

#include "core/foundation/base/error.h"

namespace vitrine::generate {
namespace {
constexpr SceneEntry kScenes[] = {{"tiny_room", tiny_room},
                                  {"paperweight", paperweight},
                                  {"cloudy", cloudy},
                                  {"smoky", smoky},
                                  {"cabinet", cabinet},
                                  {"hall", hall},
                                  {"gallery", nullptr, gallery},
                                  {"plain_gallery", nullptr, plain_gallery},
                                  {"filled_gallery", nullptr, filled_gallery}};
}

std::span<const SceneEntry> scene_list() { return kScenes; }

Scene scene_named(const std::string& name, std::optional<uint64_t> seed) {
  std::string known;
  for (const SceneEntry& entry : kScenes) {
    if (name == entry.name) {
      if (entry.build_seeded && !seed)
        throw Error(ErrorKind::Usage, fmt::format("scene '{}' needs a seed", name), {.hint = "--seed 1", .code = "USAGE"});
      if (!entry.build_seeded && seed)
        throw Error(ErrorKind::Usage, fmt::format("scene '{}' takes no seed", name),
                    {.hint = "leave --seed out", .code = "USAGE"});
      Scene scene = seed ? entry.build_seeded(*seed) : entry.build();
      scene.name = seed ? fmt::format("{}_{}", name, *seed) : name;
      return scene;
    }
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw Error(ErrorKind::Usage, fmt::format("there is no scene '{}'", name), {.hint = "one of: " + known});
}

}  // namespace vitrine::generate
