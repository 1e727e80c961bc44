#include "tests/fuzz/mutate.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>

#include "core/foundation/base/timer.h"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
// The largest single allocation that a small file may cause: a photo of 2^24 pixels in its widest form, and room.
// The library of the sanitizer finds only visible symbols.
extern "C" __attribute__((visibility("default"))) const char* __asan_default_options() { return "max_allocation_size_mb=1500"; }
#endif

namespace vitrine {

namespace {

constexpr size_t kLongest = 1 << 16;  // mutations do not grow beyond; a corpus file may

// A place, the beginning of the file more often than its end: headers decide most.
size_t place(Rng& rng, size_t size) {
  if (size == 0) return 0;
  const auto n = static_cast<uint32_t>(size);
  return rng.below(3) == 0 ? rng.below(std::min<uint32_t>(n, 256)) : rng.below(n);
}

size_t piece(Rng& rng, size_t left) {
  const auto longest = static_cast<uint32_t>(std::min<size_t>(left, rng.below(4) == 0 ? 4096 : 32));
  return longest == 0 ? 0 : 1 + rng.below(longest);
}

void put_integer(std::string& s, Rng& rng) {
  static constexpr uint64_t kExtremes[] = {0,
                                           1,
                                           0x7f,
                                           0x80,
                                           0xff,
                                           0x7fff,
                                           0x8000,
                                           0xffff,
                                           0x10000,
                                           0x7fffffff,
                                           0x80000000,
                                           0xffffffff,
                                           1ull << 32,
                                           1ull << 33,
                                           1ull << 62,
                                           ~0ull >> 1,
                                           1ull << 63,
                                           ~0ull,
                                           0x7ff0000000000000ull,
                                           0x7ff8000000000000ull,
                                           0x7f800000};
  const size_t width = size_t{1} << rng.below(4);
  if (s.size() < width) return;
  uint64_t value = kExtremes[rng.below(std::size(kExtremes))];
  if (rng.below(4) == 0) value = rng.next_u64() >> rng.below(64);
  char raw[8];
  std::memcpy(raw, &value, 8);
  if (rng.below(2) == 0) std::reverse(raw, raw + width);
  s.replace(place(rng, s.size() - width + 1), width, raw, width);
}

void mutate_once(std::string& s, const FuzzFormat& format, std::span<const std::string> corpus, Rng& rng) {
  const size_t at = place(rng, s.size());
  switch (rng.below(10)) {
    case 0:
    case 1:
      if (!s.empty()) s[at] = static_cast<char>(s[at] ^ (1 << rng.below(8)));
      break;
    case 2:
      if (!s.empty()) s[at] = static_cast<char>(rng.below(256));
      break;
    case 3:
      put_integer(s, rng);
      break;
    case 4:  // a word, over what stands there or between
      if (!format.words.empty()) {
        const std::string_view word = format.words[rng.below(static_cast<uint32_t>(format.words.size()))];
        s.replace(at, rng.below(2) == 0 ? std::min(word.size(), s.size() - at) : 0, word);
      }
      break;
    case 5:
      s.erase(at, piece(rng, s.size() - at));
      break;
    case 6:  // copied elsewhere
      s.insert(place(rng, s.size()), std::string(s.substr(at, piece(rng, s.size() - at))));
      break;
    case 7: {  // repeated: nesting, long lists
      const std::string part = s.substr(at, piece(rng, s.size() - at));
      std::string many;
      for (uint32_t n = 1u << rng.below(13); n > 0 && many.size() < kLongest; --n) many += part;
      s.insert(at, many);
      break;
    }
    case 8:
      if (rng.below(3) == 0) s.resize(at);
      break;
    default: {  // spliced with another
      const std::string& other = corpus[rng.below(static_cast<uint32_t>(corpus.size()))];
      const size_t from = place(rng, other.size()), length = piece(rng, other.size() - from);
      s.replace(at, rng.below(2) == 0 ? std::min(length, s.size() - at) : 0, other.substr(from, length));
    }
  }
}

// Without a sanitizer, the operating system keeps memory in bounds: what leads beyond ends in std::bad_alloc.
void limit_memory() {
#if !defined(__SANITIZE_ADDRESS__)
  struct rlimit limit {};
  if (getrlimit(RLIMIT_AS, &limit) != 0) return;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, rlim_t{6} << 30);
  setrlimit(RLIMIT_AS, &limit);
#endif
}

}  // namespace

std::string mutated(const FuzzFormat& format, std::span<const std::string> corpus, uint64_t seed, uint64_t number) {
  Rng rng(seed, number);
  std::string s = corpus[rng.below(static_cast<uint32_t>(corpus.size()))];
  const size_t longest = std::max(kLongest, s.size());
  for (uint32_t n = 1u << rng.below(4); n > 0; --n) mutate_once(s, format, corpus, rng);
  if (s.size() > longest) s.resize(longest);
  return s;
}

uint64_t fuzz(const FuzzFormat& format, const FuzzDesc& desc) {
  limit_memory();
  const std::vector<std::string> corpus = format.corpus();
  const Timer clock;
  uint64_t tried = 0;
  const auto run = [&](const std::string& input) {
    if (!desc.keep.empty())
      std::ofstream(desc.keep, std::ios::binary).write(input.data(), static_cast<std::streamsize>(input.size()));
    alarm(kSlowestRun);
    format.entry({reinterpret_cast<const uint8_t*>(input.data()), input.size()});
    alarm(0);
    ++tried;
  };
  for (const std::string& input : corpus) run(input);
  for (uint64_t i = desc.first; i < desc.first + desc.runs; ++i) {
    if (desc.seconds > 0 && clock.seconds() > desc.seconds) break;
    run(mutated(format, corpus, desc.seed, i));
  }
  return tried;
}

}  // namespace vitrine
