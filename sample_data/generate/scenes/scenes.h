// The list of scenes: one file, one function, one line here and in scenes.cpp.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "sample_data/generate/scene.h"

namespace vitrine::generate {

Scene tiny_room();  // opaque boxes, a ball and a ring in a painted room; 12 views of 96x64

Scene paperweight();  // a ball of solid glass in the same room; 36 views of 160x120

Scene cloudy();  // the ball filled with a cloudy liquid
Scene smoky();   // the ball filled with smoke

Scene cabinet();  // a painted owl in a glass case, a copper kettle, books; 36 views of 640x480

Scene gallery(uint64_t seed);  // glass, metal, mirrors and coated paint drawn by the seed (from 1); 24 to 48 views of 320x240

// The same things between bare walls of one paint each, and exposure and white balance of every photo are its own.
Scene plain_gallery(uint64_t seed);

// In the same rooms one or two closed vessels of glass, filled with cloudy liquid, jelly or fog (odd seeds) or smoke whose
// density varies (even seeds), some with a painted thing inside, among painted things.
Scene filled_gallery(uint64_t seed);

Scene hall();  // a painted hall, 12 m long, with crates; 300 views of 160x120 on three walks from end to end

struct SceneEntry {
  const char* name;
  Scene (*build)();  // null: a family of scenes
  Scene (*build_seeded)(uint64_t) = nullptr;
};
std::span<const SceneEntry> scene_list();
// Throws Error{Usage}: an unknown name (lists the known ones), a family without a seed, a seed for a single scene.
Scene scene_named(const std::string& name, std::optional<uint64_t> seed = {});

}  // namespace vitrine::generate
