#include "core/foundation/base/error.h"

namespace vitrine {

std::string_view name(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::Internal:
      return "INTERNAL";
    case ErrorKind::Usage:
      return "USAGE";
    case ErrorKind::Input:
      return "INPUT";
    case ErrorKind::SfmFailed:
      return "SFM_FAILED";
    case ErrorKind::QualityGate:
      return "QUALITY_GATE";
    case ErrorKind::Resource:
      return "RESOURCE";
    case ErrorKind::Dependency:
      return "DEPENDENCY";
    case ErrorKind::Device:
      return "DEVICE";
    case ErrorKind::Locked:
      return "LOCKED";
    case ErrorKind::Diverged:
      return "DIVERGED";
    case ErrorKind::Preempted:
      return "PREEMPTED";
    case ErrorKind::Interrupted:
      return "INTERRUPTED";
    case ErrorKind::Terminated:
      return "TERMINATED";
  }
  return "INTERNAL";
}

void Error::compose() {
  text_ = message_;
  if (!detail_.where.empty()) text_ += "\n  where  " + detail_.where;
  if (!detail_.why.empty()) text_ += "\n  why    " + detail_.why;
  if (!detail_.hint.empty()) text_ += "\n  try    " + detail_.hint;
}

std::string Error::with_prefix() const { return detail_.code == "BAD_CONFIG" ? text_ : "error: " + text_; }

void check_failed(const char* file, int line, const char* condition, const std::string& message) {
  throw Error(ErrorKind::Internal, "internal error: " + message,
              {.where = fmt::format("{}:{}", file, line),
               .why = fmt::format("the condition '{}' does not hold", condition),
               .hint = "this is a bug in vitrine: please report it with run.json",
               .code = "INTERNAL"});
}

}  // namespace vitrine
