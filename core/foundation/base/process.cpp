#include "core/foundation/base/process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>

#include "core/foundation/base/error.h"
#include "core/foundation/base/timer.h"

extern char** environ;

namespace vitrine {

namespace {

std::atomic<int> pending_signal{0};
std::mutex stop_mutex;
std::optional<Error> stop_reason;

void on_signal(int signal) {
  if (signal == SIGINT && pending_signal.load() == SIGINT) _exit(130);
  pending_signal.store(signal);
}

std::vector<std::string> merged_environment(const ProcessDesc& desc) {
  std::vector<std::string> all;
  for (char** e = environ; *e != nullptr; ++e) {
    const std::string_view entry(*e);
    const std::string_view key = entry.substr(0, entry.find('='));
    bool replaced = false;
    for (const auto& [k, v] : desc.environment) replaced |= k == key;
    if (!replaced) all.emplace_back(entry);
  }
  for (const auto& [k, v] : desc.environment) all.push_back(k + "=" + v);
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> out;
  for (std::string& s : strings) out.push_back(s.data());
  out.push_back(nullptr);
  return out;
}

void keep_tail(std::string& tail, std::string_view line) {
  constexpr size_t kTailBytes = 4096;
  tail.append(line).push_back('\n');
  if (tail.size() > kTailBytes) tail.erase(0, tail.size() - kTailBytes);
}

// Reads lines from a pipe until its end. `waiting` is called at least ten times a second.
void read_lines(int pipe, const std::function<void()>& waiting, const std::function<void(std::string_view)>& emit) {
  std::string pending;
  char buffer[1 << 14];
  while (true) {
    pollfd p{pipe, POLLIN, 0};
    poll(&p, 1, 100);
    waiting();
    if ((p.revents & (POLLIN | POLLHUP)) == 0) continue;
    const ssize_t n = read(pipe, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    pending.append(buffer, static_cast<size_t>(n));
    size_t begin = 0;
    for (size_t end; (end = pending.find('\n', begin)) != std::string::npos; begin = end + 1)
      emit(std::string_view(pending).substr(begin, end - begin));
    pending.erase(0, begin);
  }
  if (!pending.empty()) emit(pending);
}

}  // namespace

ProcessResult run_process(const ProcessDesc& desc) {
  VITRINE_CHECK(!desc.arguments.empty(), "no program given");
  std::vector<std::string> arguments = desc.arguments, environment = merged_environment(desc);
  std::vector<char*> argv = pointers(arguments), envp = pointers(environment);

  int pipe_fds[2] = {-1, -1};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (!desc.inherit_output) {
    if (pipe2(pipe_fds, O_CLOEXEC) != 0)
      throw Error(ErrorKind::Resource, "cannot create a pipe",
                  {.why = std::strerror(errno), .hint = "raise `ulimit -n`", .code = "NO_PIPE"});
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, pipe_fds[1], 1);
    posix_spawn_file_actions_adddup2(&actions, pipe_fds[1], 2);
  }
  if (!desc.working_folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, desc.working_folder.c_str());

  // Own process group: on Ctrl-C the terminal would also signal the child; with the forwarded signal it would receive two,
  // which means "terminate immediately".
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);

  Timer timer;
  pid_t pid = -1;
  const int rc = posix_spawnp(&pid, argv[0], &actions, &attributes, argv.data(), envp.data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (!desc.inherit_output) close(pipe_fds[1]);
  if (rc != 0) {
    if (!desc.inherit_output) close(pipe_fds[0]);
    throw Error(ErrorKind::Dependency, fmt::format("cannot start '{}'", desc.arguments[0]),
                {.why = std::strerror(rc), .hint = "run 'vitrine doctor' to see what is missing", .code = "CANNOT_START"});
  }

  ProcessResult result;
  std::ofstream log;
  if (!desc.log.empty()) {
    make_folders(desc.log.parent_path());
    log.open(desc.log, std::ios::app | std::ios::binary);
    log << "$ " << join_command(desc.arguments) << '\n';
  }
  int forwarded = 0;
  const auto forward_interrupt = [&] {
    const int signal = interrupt_signal();
    if (signal != 0 && forwarded == 0 && desc.forward_interrupts) {
      kill(pid, signal == SIGINT ? SIGINT : SIGTERM);
      forwarded = signal;
    }
  };
  if (!desc.inherit_output) {
    read_lines(pipe_fds[0], forward_interrupt, [&](std::string_view line) {
      if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
      keep_tail(result.tail, line);
      if (log) log << line << '\n';
      if (desc.on_line) desc.on_line(line);
    });
    close(pipe_fds[0]);
  }
  int status = 0;
  rusage usage{};
  while (wait4(pid, &status, 0, &usage) < 0 && errno == EINTR) forward_interrupt();
  result.seconds = timer.seconds();
  result.peak_memory_bytes = static_cast<size_t>(usage.ru_maxrss) * 1024;
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return result;
}

std::optional<fs::path> find_program(std::string_view name) {
  if (name.find('/') != std::string_view::npos)
    return access(std::string(name).c_str(), X_OK) == 0 ? std::optional<fs::path>(fs::path(name)) : std::nullopt;
  const char* path = std::getenv("PATH");
  std::string_view rest = path ? path : "/usr/bin:/bin";
  while (!rest.empty()) {
    const size_t colon = rest.find(':');
    const fs::path candidate = fs::path(rest.substr(0, colon)) / name;
    if (access(candidate.c_str(), X_OK) == 0 && fs::is_regular_file(candidate)) return candidate;
    if (colon == std::string_view::npos) break;
    rest.remove_prefix(colon + 1);
  }
  return std::nullopt;
}

std::string join_command(const std::vector<std::string>& arguments) {
  std::string out;
  for (const std::string& a : arguments) {
    if (!out.empty()) out += ' ';
    const bool plain =
        !a.empty() &&
        a.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=:,+@%") == std::string::npos;
    if (plain) {
      out += a;
      continue;
    }
    out += '\'';
    for (char c : a) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    out += '\'';
  }
  return out;
}

void install_interrupt_handlers() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  for (int s : {SIGINT, SIGTERM, SIGUSR1}) sigaction(s, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

int interrupt_signal() { return pending_signal.load(); }

void request_stop(const Error& reason) {
  std::lock_guard lock(stop_mutex);
  if (stop_reason || interrupt_signal() != 0) return;
  stop_reason = reason;
  pending_signal.store(SIGTERM);  // children are stopped with it
}

void throw_if_interrupted() {
  const int signal = interrupt_signal();
  if (signal == 0) return;
  {
    std::lock_guard lock(stop_mutex);
    if (stop_reason) throw *stop_reason;
  }
  if (signal == SIGINT)
    throw Error(ErrorKind::Interrupted, "interrupted", {.hint = "run the same command again to continue", .code = "INTERRUPTED"});
  throw Error(ErrorKind::Preempted, "stopped by a signal",
              {.hint = "run the same command again to continue", .code = "PREEMPTED"});
}

}  // namespace vitrine
