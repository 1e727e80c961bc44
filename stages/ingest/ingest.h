// Ingest: a folder of photographs becomes upright linear EXR files, 8-bit copies for structure from motion, and
// ingest/photos.json with what EXIF knows about focal length and exposure (README.md).
//
// Version history: 1 = JPEG, PNG, TIFF, EXR; 2 = photos.json holds the EXIF orientation; colour profiles are applied and named
// (README.md, "Colours"), negative values of floating-point photos stay; masks, depth maps and reduced copies beside photos are
// no photos, linked folders are followed.
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
