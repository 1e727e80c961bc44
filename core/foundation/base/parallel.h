// Parallel loops on oneTBB. Chunk borders depend on the problem only, so a reduction over chunks in chunk order gives the same
// bytes for any number of threads.
#pragma once

#include <cstddef>
#include <functional>

namespace vitrine {

// 0 = all threads allowed by machine and cgroup. Applies to the whole process until changed.
void set_thread_limit(int threads);
int thread_limit();
int hardware_threads();                        // respects CPU affinity and the cgroup quota

// body(i) for i in [0, n), in any order, on thread_limit() threads. `grain`: number of items per task.
void parallel_for(size_t n, size_t grain, const std::function<void(size_t)>& body);

// body(chunk, begin, end) with chunk = 0 .. ceil(n/chunk_size)-1; chunk borders are multiples of chunk_size.
void parallel_chunks(size_t n, size_t chunk_size, const std::function<void(size_t, size_t, size_t)>& body);
inline size_t chunk_count(size_t n, size_t chunk_size) { return (n + chunk_size - 1) / chunk_size; }

}  // namespace vitrine
