#include "core/base/parallel.h"

#include <sched.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace vitrine {

namespace {

std::mutex limit_mutex;
int limit = 0;
std::unique_ptr<tbb::global_control> control;
std::unique_ptr<tbb::task_arena> arena;

// cgroup v2 quota: "max 100000" or "<quota> <period>" in microseconds.
int cgroup_threads() {
  std::ifstream in("/sys/fs/cgroup/cpu.max");
  std::string quota;
  double period = 0;
  if (!(in >> quota >> period) || quota == "max" || period <= 0) return 1 << 20;
  return std::max(1, static_cast<int>(std::stod(quota) / period + 0.5));
}

tbb::task_arena& current_arena() {
  std::lock_guard lock(limit_mutex);
  if (!arena) {
    const int threads = limit > 0 ? limit : hardware_threads();
    control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<size_t>(std::max(threads, 1)));
    arena = std::make_unique<tbb::task_arena>(threads);
  }
  return *arena;
}

}  // namespace

int hardware_threads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  const int affinity = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
  return std::max(1, std::min(affinity, cgroup_threads()));
}

void set_thread_limit(int threads) {
  std::lock_guard lock(limit_mutex);
  limit = std::max(0, threads);
  arena.reset();
  control.reset();
}

int thread_limit() {
  std::lock_guard lock(limit_mutex);
  return limit > 0 ? limit : hardware_threads();
}

void parallel_for(size_t n, size_t grain, const std::function<void(size_t)>& body) {
  if (n == 0) return;
  current_arena().execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, n, std::max<size_t>(grain, 1)),
        [&](const tbb::blocked_range<size_t>& range) {
          for (size_t i = range.begin(); i != range.end(); ++i) body(i);
        },
        tbb::simple_partitioner());
  });
}

void parallel_chunks(size_t n, size_t chunk_size, const std::function<void(size_t, size_t, size_t)>& body) {
  parallel_for(chunk_count(n, chunk_size), 1, [&](size_t chunk) {
    body(chunk, chunk * chunk_size, std::min(n, (chunk + 1) * chunk_size));
  });
}

}  // namespace vitrine
