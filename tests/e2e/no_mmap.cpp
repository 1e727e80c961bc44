// Preloaded library: below the folder $VITRINE_TEST_NO_MMAP files cannot be mapped into shared memory, as on FUSE with direct I/O
// and on SMB without a cache.
#include <dlfcn.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

using Map = void* (*)(void*, size_t, int, int, int, off_t);

bool lies_below(int file, const char* folder) {
  char link[64], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  return length > 0 && std::strncmp(path, folder, std::strlen(folder)) == 0;
}

void* map_unless_below(void* at, size_t bytes, int protection, int flags, int file, off_t offset) {
  static const Map real = reinterpret_cast<Map>(dlsym(RTLD_NEXT, "mmap"));
  const char* folder = std::getenv("VITRINE_TEST_NO_MMAP");
  if (file >= 0 && folder != nullptr && (flags & MAP_SHARED) != 0 && lies_below(file, folder)) {
    errno = ENODEV;
    return MAP_FAILED;
  }
  return real(at, bytes, protection, flags, file, offset);
}

}  // namespace

extern "C" void* mmap(void* at, size_t bytes, int protection, int flags, int file, off_t offset) noexcept {
  return map_unless_below(at, bytes, protection, flags, file, offset);
}
extern "C" void* mmap64(void* at, size_t bytes, int protection, int flags, int file, off_t offset) noexcept {
  return map_unless_below(at, bytes, protection, flags, file, offset);
}
