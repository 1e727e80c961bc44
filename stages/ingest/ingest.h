// Stage `ingest`: a folder of photos and films -> upright linear EXR files, 8-bit copies for structure from motion, and
// ingest/photos.json with focal length and exposure from EXIF (README.md).
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct IngestConfig {
  int max_side = 1600;
  int frames = 120;
};
void describe(Describer& d, IngestConfig& c);

Stage ingest_stage();
StageCost ingest_cost(const CostTerms& terms);

}  // namespace vitrine
