#include "core/foundation/base/file.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>
#include <vector>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

fs::path temporary_beside(const fs::path& path) {
  // Keeps the extension last: image writers select the format by it.
  return path.parent_path() / fmt::format(".{}.tmp-{}{}", path.stem().string(), getpid(), path.extension().string());
}

void sync_path(const fs::path& path, int flags) {
  const int fd = open(path.c_str(), flags);
  if (fd < 0) throw_write_error(path, errno);
  const int rc = fsync(fd);
  const int saved = errno;
  close(fd);
  if (rc != 0 && saved != EINVAL && saved != EROFS) throw_write_error(path, saved);
}

}  // namespace

void throw_write_error(const fs::path& path, int errno_value) {
  ErrorDetail detail{.where = path.string(),
                     .why = std::strerror(errno_value),
                     .hint = "check the path, or choose another folder with -o",
                     .code = "WRITE_FAILED"};
  if (errno_value == ENOSPC || errno_value == EDQUOT) {
    detail.hint = "free some disk space and run the same command again: finished stages are kept";
    detail.code = "DISK_FULL";
  } else if (errno_value == EROFS || errno_value == EACCES || errno_value == EPERM || errno_value == ENOTDIR ||
             errno_value == EEXIST) {
    detail.hint = "choose an output folder you can write to with -o";
    detail.code = "NOT_WRITABLE";
  }
  throw Error(ErrorKind::Resource, "cannot write a file", detail);
}

std::string read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in || fs::is_directory(path))
    throw Error(ErrorKind::Input, "cannot read a file",
                {.where = path.string(),
                 .why = fs::exists(path) ? "it is not a readable file" : "it does not exist",
                 .hint = "check the path and its permissions",
                 .code = "UNREADABLE"});
  std::ostringstream out;
  out << in.rdbuf();
  return std::move(out).str();
}

void write_file_through(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  make_folders(path.parent_path());
  const fs::path temporary = temporary_beside(path);
  try {
    write(temporary);
    sync_path(temporary, O_RDONLY);
    if (std::rename(temporary.c_str(), path.c_str()) != 0) throw_write_error(path, errno);
  } catch (...) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
}

void write_file(const fs::path& path, std::string_view bytes) {
  write_file_through(path, [&](const fs::path& temporary) {
    const int fd = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) throw_write_error(path, errno);
    size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) {
        const int saved = errno;
        close(fd);
        throw_write_error(path, saved);
      }
      done += static_cast<size_t>(n);
    }
    if (close(fd) != 0) throw_write_error(path, errno);
  });
}

void make_folders(const fs::path& path) {
  if (path.empty()) return;
  std::error_code ec;
  fs::create_directories(path, ec);
  if (ec) throw_write_error(path, ec.value());
}

void sync_folder(const fs::path& path) { sync_path(path, O_RDONLY | O_DIRECTORY); }

void link_or_copy(const fs::path& from, const fs::path& to) {
  make_folders(to.parent_path());
  std::error_code ec;
  fs::remove(to, ec);
  fs::create_hard_link(from, to, ec);
  if (!ec) return;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, ec);
  if (ec) throw_write_error(to, ec.value());
}

size_t free_disk_bytes(const fs::path& path) {
  struct statvfs s {};
  fs::path existing = fs::absolute(path);
  while (!existing.empty() && statvfs(existing.c_str(), &s) != 0 && existing.has_relative_path())
    existing = existing.parent_path();
  return static_cast<size_t>(s.f_bavail) * s.f_frsize;
}

TemporaryFolder::TemporaryFolder(std::string_view prefix) {
  std::string pattern = (fs::temp_directory_path() / fmt::format("{}-XXXXXX", prefix)).string();
  std::vector<char> buffer(pattern.c_str(), pattern.c_str() + pattern.size() + 1);
  if (mkdtemp(buffer.data()) == nullptr) throw_write_error(pattern, errno);
  path_ = buffer.data();
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

namespace {

// Texts of these formats start with ASCII: in UTF-16 and UTF-32 every second byte, or three of four, are zero.
const char* wide_encoding(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xff\xfe\0\0"sv) || bytes.starts_with("\0\0\xfe\xff"sv)) return "UTF-32";
  if (bytes.starts_with("\xff\xfe"sv) || bytes.starts_with("\xfe\xff"sv)) return "UTF-16";
  if (bytes.size() >= 4 && (bytes[0] == 0) != (bytes[1] == 0) && (bytes[0] == 0) == (bytes[2] == 0) &&
      (bytes[1] == 0) == (bytes[3] == 0))
    return "UTF-16";
  return nullptr;
}

}  // namespace

std::string read_text_file(const fs::path& path) {
  std::string text = read_file(path);
  if (const char* encoding = wide_encoding(text))
    throw Error(ErrorKind::Input, "a text file has the wrong encoding",
                {.where = path.string(),
                 .why = std::string("it is ") + encoding + " text",
                 .hint = "save it as UTF-8 (Notepad: Save as, Encoding; PowerShell: Out-File -Encoding utf8)",
                 .code = "TEXT_ENCODING"});
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  return text;
}

size_t utf8_length(std::string_view text) {
  const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first < 0xc2 || first > 0xf4) return 0;
  const size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  const unsigned lowest = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
  const unsigned highest = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
  if (byte(1) < lowest || byte(1) > highest) return 0;
  for (size_t i = 2; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  return length;
}

}  // namespace vitrine
