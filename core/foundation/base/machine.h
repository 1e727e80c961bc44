// Memory available to the process, within the limits of machine and cgroup. For threads see core/foundation/base/parallel.h.
#pragma once

#include <sys/types.h>

#include <cstddef>

namespace vitrine {

size_t machine_memory_bytes();    // of the machine, or the cgroup limit
size_t available_memory_bytes();  // available without swapping
// Resident memory of a process and its descendants; 0 if it has ended.
size_t resident_memory_bytes(pid_t process);

}  // namespace vitrine
