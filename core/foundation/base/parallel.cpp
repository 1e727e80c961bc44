#include "core/foundation/base/parallel.h"

#include <sched.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <exception>
#include <thread>
#include <vector>
#else
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace vitrine {

namespace {

std::mutex limit_mutex;
int limit = 0;

// cgroup v2 quota: "max 100000" or "<quota> <period>" in microseconds.
int cgroup_threads() {
  std::ifstream in("/sys/fs/cgroup/cpu.max");
  std::string quota;
  double period = 0;
  if (!(in >> quota >> period) || quota == "max" || period <= 0) return 1 << 20;
  return std::max(1, static_cast<int>(std::stod(quota) / period + 0.5));
}

#ifdef __SANITIZE_THREAD__

// ThreadSanitizer cannot see the synchronisation in the uninstrumented libtbb and would report every loop as a race. Its build
// runs the loop bodies on std::thread: unordered among themselves, ordered with the code before and after the loop. Nested
// loops run sequentially on the calling thread.
void forget_threads() {}

void run_loop(size_t n, size_t grain, const std::function<void(size_t)>& body) {
  thread_local bool inside = false;
  std::atomic<size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      for (size_t begin; (begin = next.fetch_add(grain, std::memory_order_relaxed)) < n;)
        for (size_t i = begin; i < std::min(n, begin + grain); ++i) body(i);
    } catch (...) {
      next.store(n, std::memory_order_relaxed);
      std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  const size_t wanted = inside ? 1 : std::min<size_t>(static_cast<size_t>(thread_limit()), (n + grain - 1) / grain);
  std::vector<std::thread> others;
  for (size_t t = 1; t < wanted; ++t)
    others.emplace_back([&] {
      inside = true;
      work();
    });
  const bool outer = !inside;
  inside = true;
  work();
  if (outer) inside = false;
  for (std::thread& t : others) t.join();
  if (failure) std::rethrow_exception(failure);
}

#else

std::unique_ptr<tbb::global_control> control;
std::unique_ptr<tbb::task_arena> arena;

void forget_threads() {
  arena.reset();
  control.reset();
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

void run_loop(size_t n, size_t grain, const std::function<void(size_t)>& body) {
  current_arena().execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, n, grain),
        [&](const tbb::blocked_range<size_t>& range) {
          for (size_t i = range.begin(); i != range.end(); ++i) body(i);
        },
        tbb::simple_partitioner());
  });
}

#endif

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
  forget_threads();
}

int thread_limit() {
  std::lock_guard lock(limit_mutex);
  return limit > 0 ? limit : hardware_threads();
}

void parallel_for(size_t n, size_t grain, const std::function<void(size_t)>& body) {
  if (n > 0) run_loop(n, std::max<size_t>(grain, 1), body);
}

void parallel_chunks(size_t n, size_t chunk_size, const std::function<void(size_t, size_t, size_t)>& body) {
  parallel_for(chunk_count(n, chunk_size), 1,
               [&](size_t chunk) { body(chunk, chunk * chunk_size, std::min(n, (chunk + 1) * chunk_size)); });
}

}  // namespace vitrine
