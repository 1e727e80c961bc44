#include "stages/reporter.h"

#include <unistd.h>

#include <chrono>

#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/terminal.h"
#include "core/foundation/base/timer.h"

namespace vitrine {

MemoryWatch::MemoryWatch(size_t limit_bytes, std::string stage) {
  if (limit_bytes > 0) thread_ = std::thread([this, limit_bytes, name = std::move(stage)] { watch(limit_bytes, name); });
}

MemoryWatch::~MemoryWatch() {
  if (!thread_.joinable()) return;
  {
    std::lock_guard lock(mutex_);
    ended_ = true;
  }
  end_.notify_all();
  thread_.join();
}

void MemoryWatch::watch(size_t limit_bytes, const std::string& stage) {
  constexpr auto kPeriod = std::chrono::milliseconds(100);
  std::unique_lock lock(mutex_);
  while (!end_.wait_for(lock, kPeriod, [&] { return ended_; })) {
    const size_t used = resident_memory_bytes(getpid());
    if (used <= limit_bytes) continue;
    request_stop(Error(ErrorKind::Resource, fmt::format("stage '{}' needs more memory than it may take", stage),
                       {.where = "--max-memory " + bytes_text(limit_bytes),
                        .why = fmt::format("it holds {}; its checkpoint, if it writes any, is kept", bytes_text(used)),
                        .hint = less_memory_hint(stage),
                        .code = "OUT_OF_MEMORY"}));
    return;
  }
}

std::string less_memory_hint(const std::string& stage) {
  struct Hint {
    const char *stage, *words;
  };
  constexpr Hint kHints[] = {
      {"ingest", "--set ingest.max_side=1024"},
      {"sfm", "--set sfm.max_image_size=1600, or fewer threads: -j 1"},
      {"masks", "--set ingest.max_side=1024"},
      {"normals", "--set normals.geometric.max_side=192"},
      {"optimize", "--max-gaussians 50000 --set optimize.max_side=640"},
      {"mesh", "--set mesh.resolution=192"},
      {"refine", "--set optimize.max_side=640"},
      {"decompose", "--set mesh.faces=50000"},
      {"evaluate", "--set optimize.max_side=640"},
      {"export", "--set mesh.faces=50000"},
  };
  for (const Hint& h : kHints)
    if (stage == h.stage) return std::string(h.words) + ", or a larger limit";
  return "a larger --max-memory";
}

}  // namespace vitrine
