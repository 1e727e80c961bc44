// marks.yaml of a scene: boxes around its glass, mirrors and coats in three photos each, as somebody in a hurry would draw them.
#pragma once

#include <filesystem>

#include "sample_data/generate/scene.h"

namespace vitrine::generate {

// A thing is what the name of its parts says before the slash. Up to a tenth of its size too wide on every side, never too small;
// photos that learn, show all of it, and look from different sides. A thing that three photos do not show whole has no marks, and
// a scene without marks has no file.
void write_marks(const Scene& scene, const std::filesystem::path& file);

}  // namespace vitrine::generate
