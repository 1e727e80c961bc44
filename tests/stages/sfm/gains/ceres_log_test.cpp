#include "stages/sfm/gains/ceres_log.h"

#include <glog/logging.h>
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"

namespace vitrine {
namespace {

TEST(CeresLog, MessagesOfCeresStandInTheLogOfTheStageOnly) {
  const TemporaryFolder folder;
  set_log_file(folder.path() / "log.txt");
  set_log_console(LogLevel::Warning, false);
  ceres_to_log();
  ceres_to_log();
  testing::internal::CaptureStderr();
  LOG(WARNING) << "a linear solver failed";
  LOG(ERROR) << "a residual is no number";
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  const std::string log = read_file(folder.path() / "log.txt");
  EXPECT_NE(log.find("Ceres: a linear solver failed"), std::string::npos) << log;
  EXPECT_NE(log.find("Ceres: a residual is no number"), std::string::npos) << log;
}

}  // namespace
}  // namespace vitrine
