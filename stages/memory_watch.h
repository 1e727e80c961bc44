// --max-memory, for whatever a stage does: while it runs, the resident memory of its process and of the programs that it started
// is looked at ten times a second; above the limit the stage is asked to stop (core/base/process.h, request_stop), which keeps
// its checkpoint and ends with exit code 6. Stages that can do with less do so before (ingest, sfm, optimize).
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace vitrine {

class MemoryWatch {
 public:
  // limit_bytes 0 = watches nothing.
  MemoryWatch(size_t limit_bytes, std::string stage);
  ~MemoryWatch();
  MemoryWatch(const MemoryWatch&) = delete;
  MemoryWatch& operator=(const MemoryWatch&) = delete;

 private:
  void watch(size_t limit_bytes, const std::string& stage);
  std::mutex mutex_;
  std::condition_variable end_;
  bool ended_ = false;
  std::thread thread_;
};

// What helps a stage to need less memory, as a command line's words.
std::string less_memory_hint(const std::string& stage);

}  // namespace vitrine
