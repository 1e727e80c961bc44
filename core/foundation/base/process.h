// Child processes without a shell: arguments are passed as they are, output is read line by line while the child runs.
// The child has a process group of its own; a signal that asks us to stop (see below) is passed on to it, and `run_process` waits
// until it has ended: the caller then looks at interrupt_signal().
#pragma once

#include <csignal>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/file.h"

namespace vitrine {

class Error;

struct ProcessDesc {
  std::vector<std::string> arguments;                                 // [0] = program, looked up in PATH
  std::vector<std::pair<std::string, std::string>> environment = {};  // added to ours
  fs::path working_folder = {};
  fs::path log = {};                                        // when set, everything printed is also written here
  std::function<void(std::string_view line)> on_line = {};  // stdout and stderr, in order of arrival
  bool inherit_output = false;                              // child writes to our own stdout and stderr
  bool forward_interrupts = true;                           // false: short work that is to be done although we were asked to stop
};

struct ProcessResult {
  int exit_code = 0;  // valid when signal == 0
  int signal = 0;     // the signal that ended it
  double seconds = 0;
  size_t peak_memory_bytes = 0;
  std::string tail;  // the last lines printed (at most 4 KiB)
  bool ok() const { return signal == 0 && exit_code == 0; }
};

// Throws Error{Dependency} when the program cannot be started.
ProcessResult run_process(const ProcessDesc& desc);
std::optional<fs::path> find_program(std::string_view name);          // through PATH
std::string join_command(const std::vector<std::string>& arguments);  // quoted for a person to paste

// --- interruption ---------------------------------------------------------------------------------------------------
// After install_interrupt_handlers(), the first SIGINT / SIGTERM / SIGUSR1 only sets a flag; a second SIGINT ends at once.
void install_interrupt_handlers();
// 0, or the signal that asked us to stop.
int interrupt_signal();
// Asks this process to stop for a reason of its own, as a signal would: work ends at its next step, with its checkpoint, and
// throw_if_interrupted() throws `reason`. The first reason counts.
void request_stop(const Error& reason);
// Throws Error{Interrupted} (SIGINT), {Preempted} (SIGTERM, SIGUSR1) or the reason of request_stop when asked to stop. Call
// between steps of long work.
void throw_if_interrupted();

}  // namespace vitrine
