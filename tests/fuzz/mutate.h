// Damaged copies of valid inputs, the same for a seed and a number on every machine.
#pragma once

#include "core/foundation/base/rng.h"
#include "tests/fuzz/formats.h"

namespace vitrine {

// One to eight of: bits turned over, bytes replaced, an integer at its extremes, a word of the format, a part cut out, copied
// elsewhere or repeated many times, the end cut off, a piece of another input.
std::string mutated(const FuzzFormat& format, std::span<const std::string> corpus, uint64_t seed, uint64_t number);

struct FuzzDesc {
  uint64_t runs = 1000, seed = 1, first = 0;
  double seconds = 0;     // 0: no limit; otherwise no run begins after it
  std::string keep = {};  // the input of the current run is written here first, so that a crash leaves it
};
// The corpus itself, then the mutations. Returns how many inputs were tried. Throws what the entry throws; a run that takes
// longer than kSlowestRun ends the process by SIGALRM.
inline constexpr unsigned kSlowestRun = 30;  // seconds
uint64_t fuzz(const FuzzFormat& format, const FuzzDesc& desc);

}  // namespace vitrine
