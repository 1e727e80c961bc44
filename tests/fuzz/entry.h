// What the entry functions of formats.h share.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "tests/fuzz/formats.h"

namespace vitrine {

inline std::string_view text_of(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Files of the current input lie here; the folder lives as long as the process.
inline const fs::path& fuzz_folder() {
  static const bool in_memory = access("/dev/shm", W_OK) == 0 && setenv("TMPDIR", "/dev/shm", 1) == 0;
  static const TemporaryFolder folder(in_memory ? "vitrine-fuzz-shm" : "vitrine-fuzz");
  return folder.path();
}

// Without the fsync of write_file: this is done many thousand times.
inline fs::path input_file(std::string_view name, std::string_view bytes) {
  const fs::path path = fuzz_folder() / name;
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path;
}

// The input's parts; the last takes what is left, missing ones are empty.
inline std::vector<std::string_view> parts_of(std::span<const uint8_t> bytes, size_t count) {
  std::vector<std::string_view> parts(count);
  std::string_view rest = text_of(bytes);
  for (size_t i = 0; i < count; ++i) {
    const size_t end = i + 1 < count ? rest.find(kPartMark) : std::string_view::npos;
    parts[i] = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + kPartMark.size());
  }
  return parts;
}

// Lets an Error of the user's pass; one that says "this is a bug in vitrine" is a defect.
template <class Parse>
void refuses_or_reads(Parse&& parse) {
  try {
    parse();
  } catch (const Error& e) {
    if (e.kind() == ErrorKind::Internal) throw std::logic_error(e.what());
  }
}

}  // namespace vitrine
