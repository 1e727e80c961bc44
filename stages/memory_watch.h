// Enforces --max-memory while a stage runs: polls the resident memory of the process and its child processes ten times a second.
// Above the limit it requests a stop (core/foundation/base/process.h, request_stop): the stage keeps its checkpoint and exits with code 6.
// Stages that can reduce their memory do so beforehand (ingest, sfm, optimize).
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace vitrine {

class MemoryWatch {
 public:
  // limit_bytes 0: no limit, no polling.
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

// Command-line options that reduce the memory of a stage.
std::string less_memory_hint(const std::string& stage);

}  // namespace vitrine
