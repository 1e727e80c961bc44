// The Error that a call ends with. The test fails when it ends well.
#pragma once

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"

namespace vitrine {

template <class F>
Error error_of(F&& f) {
  try {
    f();
  } catch (const Error& e) {
    return e;
  }
  ADD_FAILURE() << "no error was raised";
  return Error(ErrorKind::Internal, "none");
}

}  // namespace vitrine
