// The list of scenes: one file, one function, one line here and in scenes.cpp.
#pragma once

#include <span>
#include <string>

#include "sample_data/generate/scene.h"

namespace vitrine::generate {

Scene tiny_room();  // opaque boxes, a ball and a ring in a painted room; 12 views of 96x64

Scene paperweight();  // a ball of solid glass in the same room; 36 views of 160x120

Scene cabinet();  // a painted owl in a glass case, a copper kettle, books; 36 views of 640x480

struct SceneEntry {
  const char* name;
  Scene (*build)();
};
std::span<const SceneEntry> scene_list();
Scene scene_named(const std::string& name);  // throws Error{Usage} that lists the names

}  // namespace vitrine::generate
