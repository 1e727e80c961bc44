// What the evaluate stage measures of a capture, as its tests read it.
#pragma once

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "stages/evaluate/evaluate.h"
#include "tests/support/recording_context.h"

namespace vitrine::test {

inline nlohmann::json metrics_of(RecordingContext& context, const EvaluateConfig& config) {
  run_evaluate(config, context);
  return nlohmann::json::parse(read_file(context.output() / "eval/metrics.json"));
}

inline EvaluateConfig quick() {
  EvaluateConfig c;
  c.mesh_samples = 20'000;
  return c;
}

}  // namespace vitrine::test
