// Messages of Ceres, which it writes with glog.
#pragma once

namespace vitrine {

// Sends them to the log of the stage (level Debug) instead of stderr. Call before the first use of Ceres; thread-safe.
void ceres_to_log();

}  // namespace vitrine
