// What this machine gives a process: memory, as far as the machine and the cgroup allow; threads are in core/foundation/base/parallel.h.
#pragma once

#include <sys/types.h>

#include <cstddef>

namespace vitrine {

size_t machine_memory_bytes();    // of the machine, or the cgroup's limit
size_t available_memory_bytes();  // that could be used now without swapping
// Resident memory of a process and all that it has started; 0 when it is gone.
size_t resident_memory_bytes(pid_t process);

}  // namespace vitrine
