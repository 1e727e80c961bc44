#include "sample_data/generate/scenes/scenes.h"

#include "core/base/error.h"

namespace vitrine::generate {
namespace {
constexpr SceneEntry kScenes[] = {{"tiny_room", tiny_room}, {"paperweight", paperweight}, {"cabinet", cabinet}};
}

std::span<const SceneEntry> scene_list() { return kScenes; }

Scene scene_named(const std::string& name) {
  std::string known;
  for (const SceneEntry& entry : kScenes) {
    if (name == entry.name) {
      Scene scene = entry.build();
      scene.name = entry.name;
      return scene;
    }
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw Error(ErrorKind::Usage, fmt::format("there is no scene '{}'", name), {.hint = "one of: " + known});
}

}  // namespace vitrine::generate
