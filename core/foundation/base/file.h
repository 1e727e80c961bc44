// Atomic file input and output. Failures throw Error{Input} (reading) or Error{Resource} (no space, read-only, no write
// permission) with the path.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace vitrine {

namespace fs = std::filesystem;

std::string read_file(const fs::path& path);
// Reads a UTF-8 text without its byte order mark. Also throws Error{Input} for UTF-16 and UTF-32.
std::string read_text_file(const fs::path& path);
// Writes a temporary file in the same folder, fsyncs it, and renames it over the target.
void write_file(const fs::path& path, std::string_view bytes);
// For writers that need a path (OpenEXR, OpenCV): `write` receives a temporary path next to `path` with the same extension.
void write_file_through(const fs::path& path, const std::function<void(const fs::path&)>& write);
void make_folders(const fs::path& path);
// fsync of a folder, so that renames inside it survive a power failure.
void sync_folder(const fs::path& path);
// Hard link, else copy. Creates parent folders, replaces an existing target.
void link_or_copy(const fs::path& from, const fs::path& to);
size_t free_disk_bytes(const fs::path& path);
// Throws the Error for a failed write to `path` with this errno.
[[noreturn]] void throw_write_error(const fs::path& path, int errno_value);

// Temporary folder, removed with all its contents at the end of the scope.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(std::string_view prefix = "vitrine");  // below $TMPDIR or /tmp
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// UTF-8 helpers.

// Length of the first sequence of non-empty `text`; 0 if it is not well-formed (The Unicode Standard, table 3-7): overlong
// forms, surrogate halves, code points above U+10FFFF.
size_t utf8_length(std::string_view text);

// Lower case for ASCII letters; all other bytes are unchanged.
inline std::string lowered(std::string_view text) {
  std::string low(text);
  for (char& c : low)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return low;
}

}  // namespace vitrine
