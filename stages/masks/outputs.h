// Writes the masks of all classes: soft PNGs at the size of the photos, confidence, COLMAP-style copies, report.
#pragma once

#include <array>
#include <memory>
#include <span>

#include <nlohmann/json_fwd.hpp>

#include "stages/masks/mask_source.h"
#include "stages/stage.h"

namespace vitrine {

// nullptr: nobody asked for that class.
using MaskSources = std::array<std::unique_ptr<MaskSource>, kMaskClassCount>;

struct ClassResult {
  std::vector<double> coverage;  // [view] share of the photo, soft values counted as they are
  bool kept = false;             // some pixel somewhere belongs to it: it has a folder
  double mean_coverage() const;
};

struct MaskResults {
  std::array<ClassResult, kMaskClassCount> classes;
};

struct MaskOutputDesc {
  const MaskCapture& capture;
  const MaskSources& sources;
  std::filesystem::path output;
};

// What a photo without a mask gets, with confidence 0: nothing of the class, except that all of it may be the object.
float value_without_mask(MaskClass kind);

MaskResults write_masks(const MaskOutputDesc& desc, StageContext& context);
// `things`: what marks call what they outline.
void write_mask_report(const MaskOutputDesc& desc, const MaskResults& results, const std::vector<std::string>& things = {});

// For a person to judge: masks/contact_sheet.png shows some photos as they are, with the classes painted in, and the confidence.
// Nothing when no class was kept. Reads the masks back from the output.
void write_contact_sheet(const MaskOutputDesc& desc, const MaskResults& results);

}  // namespace vitrine
