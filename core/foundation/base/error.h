// Error handling. Three kinds of failure: internal bugs (VITRINE_CHECK), errors the user can fix (throw Error), expected misses
// (std::optional). An Error contains what failed, where, why, and a suggested action; its kind is the process exit code
// (stages/README.md). The only catch blocks are in stage_main and the pipeline's main.
#pragma once

#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace vitrine {

// Values are the exit codes seen by scripts: never renumber.
enum class ErrorKind : int {
  Internal = 1,       // internal bug
  Usage = 2,          // bad flag or configuration
  Input = 3,          // missing, unreadable or inconsistent input
  SfmFailed = 4,      // no usable camera model
  QualityGate = 5,    // finished, but below the gates
  Resource = 6,       // memory, disk or time exhausted; state saved
  Dependency = 7,     // external program missing or too old
  Device = 8,         // requested device unusable
  Locked = 9,         // another run has locked the folder
  Diverged = 10,      // optimisation produced NaN or collapsed
  Preempted = 75,     // SIGTERM/SIGUSR1 with checkpoint
  Interrupted = 130,  // Ctrl-C
  Terminated = 143,
};

std::string_view name(ErrorKind kind);  // "INPUT", "SFM_FAILED", ...
inline int exit_code(ErrorKind kind) { return static_cast<int>(kind); }

struct ErrorDetail {
  std::string where = {};  // location: file, file:line:col, option or view
  std::string why = {};    // cause, with evidence
  std::string hint = {};   // suggested command or edit
  std::string code = {};   // stable identifier, e.g. "SFM_TOO_FEW_REGISTERED"
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
  // Several lines: message, then where / why / try if set. For terminals of 80 columns.
  const char* what() const noexcept override { return text_.c_str(); }
  // Message with the prefix "error: ", except if every error in it already has a place and a prefix ("marks.yaml:3:1: error:
  // ...", "--set: error: ..."; ConfigErrors).
  std::string with_prefix() const;

 private:
  void compose();
  ErrorKind kind_;
  std::string message_;
  ErrorDetail detail_;
  std::string text_;
};

[[noreturn]] void check_failed(const char* file, int line, const char* condition, const std::string& message);

// Notes of file readers: assumptions and omissions. A stage reports them as warnings; `vitrine inspect` prints them.
struct Note {
  std::string code;  // stable warning identifier; empty: information only
  std::string text;  // one sentence
};
using Notes = std::vector<Note>;

}  // namespace vitrine

// Checks an invariant of our own code: fails with ErrorKind::Internal. Always enabled.
#define VITRINE_CHECK(condition, ...)                                                                      \
  do {                                                                                                     \
    if (!(condition)) ::vitrine::check_failed(__FILE__, __LINE__, #condition, ::fmt::format(__VA_ARGS__)); \
  } while (false)
