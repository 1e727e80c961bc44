// Ingest: a folder of photographs becomes upright linear EXR files, 8-bit copies for structure from motion, and
// ingest/photos.json with what EXIF knows about focal length and exposure (README.md).
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct IngestConfig {
  int max_side = 1600;
};
void describe(Describer& d, IngestConfig& c);

Stage ingest_stage();
StageCost ingest_cost(const CostTerms& terms);

}  // namespace vitrine
