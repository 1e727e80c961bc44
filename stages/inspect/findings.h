// Findings of the inspection: problems of a photo set, their effect, and advice.
#pragma once

#include "stages/inspect/photo_facts.h"

namespace vitrine {

enum class Severity { Note, Warning, Problem };  // Problem: the reconstruction is likely to fail, or to lose these photos
std::string_view name(Severity s);

struct Finding {
  std::string code;  // "soft_photos"
  Severity severity = Severity::Note;
  std::string what, why, hint;
  std::vector<size_t> photos;  // indices; empty: the whole set
};

struct SetFigures {
  size_t usable = 0;
  std::optional<double> blur, exposure_range_ev, white_balance_range;  // median blur, ranges over usable photos
  double texture = 0, clipped_high = 0, clipped_low = 0, brightness_range_ev = 0;
};

struct Findings {
  SetFigures figures;
  std::vector<Finding> list;  // worst first
};

void worst_first(std::vector<Finding>& list);

// A photo is soft if its blur exceeds `soft_ratio` times that of the set.
Findings findings_of(const PhotoFolder& folder, const std::vector<PhotoFacts>& photos, double soft_ratio);

}  // namespace vitrine
