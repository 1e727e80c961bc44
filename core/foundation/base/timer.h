// Wall clock time, CPU time and memory: of this process, and of the machine. For threads see core/foundation/base/parallel.h.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <chrono>
#include <cstddef>

namespace vitrine {

class Timer {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  void restart() { start_ = Clock::now(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

inline double cpu_seconds(int who = RUSAGE_SELF) {
  rusage u{};
  getrusage(who, &u);
  return double(u.ru_utime.tv_sec + u.ru_stime.tv_sec) + 1e-6 * double(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}
inline size_t peak_memory_bytes(int who = RUSAGE_SELF) {
  rusage u{};
  getrusage(who, &u);
  return static_cast<size_t>(u.ru_maxrss) * 1024;     // Linux reports KiB
}

// Memory available to the process, within the limits of machine and cgroup.
size_t machine_memory_bytes();    // of the machine, or the cgroup limit
size_t available_memory_bytes();  // available without swapping
// Resident memory of a process and its descendants; 0 if it has ended.
size_t resident_memory_bytes(pid_t process);

}  // namespace vitrine
