// Output of the masks of all classes: soft PNGs at photo size, confidence, COLMAP-style copies, report.
#pragma once

#include <array>
#include <memory>
#include <span>

#include <nlohmann/json_fwd.hpp>

#include "stages/masks/mask_source.h"
#include "stages/stage.h"

namespace vitrine {

// nullptr: class not requested.
using MaskSources = std::array<std::unique_ptr<MaskSource>, kMaskClassCount>;

struct ClassResult {
  std::vector<double> coverage;  // [view] share of the photo, sum of the soft values
  bool kept = false;             // some pixel belongs to it: it has a folder
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

// Value of a photo without a mask, with confidence 0: not in the class, except that all of it may be the object.
float value_without_mask(MaskClass kind);

MaskResults write_masks(const MaskOutputDesc& desc, StageContext& context);
// `objects`: names of the marked objects.
void write_mask_report(const MaskOutputDesc& desc, const MaskResults& results, const std::vector<std::string>& objects = {});

// Writes masks/contact_sheet.png for visual inspection: some photos, overlaid with the classes and the confidence. Writes nothing
// when no class was kept. Reads the masks from the output folder.
void write_contact_sheet(const MaskOutputDesc& desc, const MaskResults& results);

}  // namespace vitrine
