// One lit room for all tests of the whole stage, and options that are enough for it.
#pragma once

#include <cmath>

#include "stages/decompose/decompose.h"
#include "tests/stages/decompose/lit_room.h"

namespace vitrine::test {

inline const LitRoom& room() {
  static const LitRoom instance;
  return instance;
}

inline DecomposeConfig quick() {
  DecomposeConfig config;
  config.points = 2500;
  config.bands = 12;
  config.max_side = 112;
  config.panorama_height = 16;
  config.sheet_rows = 1;
  config.solver_points = 1200;
  config.solver_rounds = 10;
  return config;
}

}  // namespace vitrine::test
