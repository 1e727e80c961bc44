#include "core/foundation/base/timer.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

#include <fmt/format.h>

namespace vitrine {

namespace {

// Reads a number from a cgroup v2 file; nullopt if missing or "max".
std::optional<size_t> cgroup_number(const char* file) {
  std::ifstream in(std::string("/sys/fs/cgroup/") + file);
  size_t value = 0;
  if (!(in >> value)) return std::nullopt;
  return value;
}

// Reads the value of a "name value ..." line.
std::optional<size_t> named_number(const char* file, const std::string& wanted) {
  std::ifstream in(file);
  std::string name, rest;
  size_t value = 0;
  while (in >> name >> value) {
    if (name == wanted) return value;
    std::getline(in, rest);
  }
  return std::nullopt;
}

size_t page_bytes() { return static_cast<size_t>(sysconf(_SC_PAGE_SIZE)); }

}  // namespace

size_t machine_memory_bytes() {
  const size_t machine = static_cast<size_t>(sysconf(_SC_PHYS_PAGES)) * page_bytes();
  return std::min(machine, cgroup_number("memory.max").value_or(machine));
}

size_t available_memory_bytes() {
  size_t available = named_number("/proc/meminfo", "MemAvailable:").value_or(machine_memory_bytes() >> 10) << 10;
  if (const auto limit = cgroup_number("memory.max")) {
    // Inactive file cache can be reclaimed.
    const size_t used = cgroup_number("memory.current").value_or(0);
    const size_t files = named_number("/sys/fs/cgroup/memory.stat", "inactive_file").value_or(0);
    available = std::min(available, *limit - std::min(*limit, used - std::min(used, files)));
  }
  return available;
}

size_t resident_memory_bytes(pid_t process) {
  size_t total = 0, resident = 0;
  if (!(std::ifstream(fmt::format("/proc/{}/statm", process)) >> total >> resident)) return 0;
  size_t bytes = resident * page_bytes();
  // Children are listed under the thread that started them; we start them on the main thread.
  std::ifstream children(fmt::format("/proc/{0}/task/{0}/children", process));
  for (pid_t child; children >> child;) bytes += resident_memory_bytes(child);
  return bytes;
}

}  // namespace vitrine
