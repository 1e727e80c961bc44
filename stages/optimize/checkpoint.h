// A checkpoint: format version, digest, state of the trainer. Written whole or not at all; damaged ones are not loaded.
#pragma once

#include <filesystem>

#include "stages/optimize/trainer.h"

namespace vitrine {

void write_checkpoint(const std::filesystem::path& path, const Trainer& trainer);
// False when there is no file. Throws Error{Input} when it is damaged or of another version; the trainer is then unusable.
bool load_checkpoint(const std::filesystem::path& path, Trainer& trainer);

}  // namespace vitrine
