// The three kinds of failure of house rules: a bug of ours (VITRINE_CHECK), something the user can fix (throw Error), a miss
// that is a normal answer (std::optional). An Error says what went wrong, where, why, and what to try; its kind is the
// process exit code (stages/README.md). There is one catch, in stage_main and in the pipeline's main.
#pragma once

#include <exception>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace vitrine {

// The numbers are the exit codes that scripts see: never renumber.
enum class ErrorKind : int {
  Internal = 1,       // our bug
  Usage = 2,          // bad flag or configuration
  Input = 3,          // missing, unreadable or inconsistent input
  SfmFailed = 4,      // no usable camera model
  QualityGate = 5,    // finished, but below the gates
  Resource = 6,       // memory, disk or time exhausted; state saved
  Dependency = 7,     // external program missing or too old
  Device = 8,         // requested device unusable
  Locked = 9,         // another run owns the folder
  Diverged = 10,      // optimisation produced NaN or collapsed
  Preempted = 75,     // SIGTERM/SIGUSR1 with checkpoint
  Interrupted = 130,  // Ctrl-C
  Terminated = 143,
};

std::string_view name(ErrorKind kind);  // "INPUT", "SFM_FAILED", ...
inline int exit_code(ErrorKind kind) { return static_cast<int>(kind); }

struct ErrorDetail {
  std::string where = {};  // file, file:line:col, option or view: the place to look
  std::string why = {};    // the cause, with the evidence
  std::string hint = {};   // what to try: a command or an edit
  std::string code = {};   // stable machine word, e.g. "SFM_TOO_FEW_REGISTERED"
};

class Error : public std::exception {
 public:
  Error(ErrorKind kind, std::string message, ErrorDetail detail = {})
      : kind_(kind), message_(std::move(message)), detail_(std::move(detail)) {
    compose();
  }

  ErrorKind kind() const { return kind_; }
  const std::string& message() const { return message_; }
  const ErrorDetail& detail() const { return detail_; }
  // Several lines: message, then where / why / try when given. Ready for a terminal of 80 columns.
  const char* what() const noexcept override { return text_.c_str(); }
  // The same as the user is told it: "error: " before it, unless every mistake names its place and says so itself
  // ("marks.yaml:3:1: error: ...", "--set: error: ..."; ConfigErrors).
  std::string told() const;

 private:
  void compose();
  ErrorKind kind_;
  std::string message_;
  ErrorDetail detail_;
  std::string text_;
};

[[noreturn]] void check_failed(const char* file, int line, const char* condition, const std::string& message);

}  // namespace vitrine

// A broken promise of our own code: stops with ErrorKind::Internal. Always on.
#define VITRINE_CHECK(condition, ...)                                                                      \
  do {                                                                                                     \
    if (!(condition)) ::vitrine::check_failed(__FILE__, __LINE__, #condition, ::fmt::format(__VA_ARGS__)); \
  } while (false)
