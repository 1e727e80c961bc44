// The stages of this build.
#pragma once

#include <cstdlib>

#include "pipeline/graph.h"

namespace vitrine {

inline const Graph& graph() {
  unsetenv("VITRINE_STAGE_DIR");
  unsetenv("VITRINE_CONFIG_DIR");
  static const Graph instance = load_graph(VITRINE_BIN_DIR);
  return instance;
}

}  // namespace vitrine
