#include "stages/sfm/gains/ceres_log.h"

#include <glog/logging.h>

#include <mutex>
#include <string_view>

#include "core/foundation/base/log.h"

namespace vitrine {

namespace {

class StageLog : public google::LogSink {
 public:
  void send(google::LogSeverity severity, const char*, const char* file, int line, const google::LogMessageTime&,
            const char* message, size_t length) override {
    log_debug("Ceres: {} ({}:{}, severity {})", std::string_view(message, length), file, line, int(severity));
  }
};

}  // namespace

void ceres_to_log() {
  static std::once_flag once;
  std::call_once(once, [] {
    static StageLog log;
    if (!google::IsGoogleLoggingInitialized()) google::InitGoogleLogging("vitrine-sfm");
    for (const auto severity : {google::GLOG_INFO, google::GLOG_WARNING, google::GLOG_ERROR, google::GLOG_FATAL})
      google::SetLogDestination(severity, "");  // no files in /tmp
    FLAGS_logtostderr = false;
    FLAGS_stderrthreshold = google::GLOG_FATAL;  // before a failed check of Ceres ends the program
    google::AddLogSink(&log);
  });
}

}  // namespace vitrine
