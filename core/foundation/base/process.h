// Child processes without a shell: arguments are passed verbatim, output is read line by line while the child runs. The child
// has its own process group. Stop signals (see below) are forwarded to it, and `run_process` waits until it has ended; the
// caller then checks interrupt_signal().
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
  std::vector<std::pair<std::string, std::string>> environment = {};  // added to the current environment
  fs::path working_folder = {};
  fs::path log = {};                                        // if set, all output is also written here
  std::function<void(std::string_view line)> on_line = {};  // stdout and stderr, in order of arrival
  bool inherit_output = false;                              // the child uses our stdout and stderr
  bool forward_interrupts = true;                           // false: short work that must finish despite a stop signal
};

struct ProcessResult {
  int exit_code = 0;  // valid when signal == 0
  int signal = 0;     // signal that terminated it
  double seconds = 0;
  size_t peak_memory_bytes = 0;
  std::string tail;  // last lines of output (at most 4 KiB)
  bool ok() const { return signal == 0 && exit_code == 0; }
};

// Throws Error{Dependency} if the program cannot be started.
ProcessResult run_process(const ProcessDesc& desc);
std::optional<fs::path> find_program(std::string_view name);          // searches PATH
std::string join_command(const std::vector<std::string>& arguments);  // shell-quoted for display

// --- interruption ---------------------------------------------------------------------------------------------------
// After install_interrupt_handlers(), the first SIGINT / SIGTERM / SIGUSR1 only sets a flag; a second SIGINT terminates
// immediately.
void install_interrupt_handlers();
// Received stop signal, or 0.
int interrupt_signal();
// Stops this process for an internal reason, like a signal: work ends at its next step, with its checkpoint, and
// throw_if_interrupted() throws `reason`. The first reason is kept.
void request_stop(const Error& reason);
// Throws Error{Interrupted} (SIGINT), {Preempted} (SIGTERM, SIGUSR1) or the reason of request_stop if a stop was requested.
// Call between steps of long work.
void throw_if_interrupted();

}  // namespace vitrine
