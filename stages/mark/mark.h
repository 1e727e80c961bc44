// mark: one HTML file with the photos, in which people annotate glass and metal, and which saves marks.yaml (README). Started by
// `vitrine mark`; not part of the graph of `vitrine run`.
//   reads   the user's photos; optionally a file of marks, and of a run sfm (cameras) and masks (propagated marks)
//   writes  mark.html
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/intake/photos/photo_files.h"
#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"
#include "stages/stage.h"

namespace vitrine {

struct MarkConfig {
  int photo_side = 1600;
  int megapixels = 120;
  std::string command = "vitrine run PHOTOS -o OUT --masks marks.yaml";
};
void describe(Describer& d, MarkConfig& c);

// `page`: HTML without photos (stages/page_text.h).
void write_mark(const std::string& page, const MarkConfig& config, StageContext& context);
void run_mark(const MarkConfig& config, StageContext& context);
Stage mark_stage();

// Photos for the page: upright as ingest reads them, reduced, JPEG, with the full size that mark coordinates refer to.

struct PagePhoto {
  std::string name;                   // name in marks and in all stages
  std::string failure = {};           // reason why it cannot be read; all other members are empty then
  int width = 0, height = 0;          // upright, as photographed
  std::string digest = {};            // of the file
  std::string jpeg = {}, small = {};  // the picture; a thumbnail for the list
};

// Longest side of the pictures: `side`, reduced so that all pictures together have at most `megapixels`, but at least kLeastSide.
int side_of_page(const std::vector<std::pair<int, int>>& sizes, int side, double megapixels);
inline constexpr int kLeastSide = 640;

// In the order of the folder. `progress` receives the number of photos done.
std::vector<PagePhoto> page_photos(const PhotoFolder& folder, int side, double megapixels,
                                   const std::function<void(size_t)>& progress);

// Results of a run for the page: cameras, and the propagated masks, resampled to the original (distorted) photos in which people
// annotate.

// Run-length encoded mask, row by row: alternating lengths of outside and inside runs, starting outside.
using MaskRuns = std::vector<int>;

struct RunPhoto {
  View view;                                                   // of the undistorted photo
  double width = 0, height = 0;                                // of the photo as ingested, distorted
  int mask_width = 0, mask_height = 0;                         // of the masks below
  std::array<std::optional<MaskRuns>, kMaskClassCount> masks;  // [class] in the frame of the original photo
};

struct RunResults {
  std::map<std::string, RunPhoto> photos;      // by name; photos with a camera
  std::map<std::string, std::string> sources;  // class -> source of its masks: "boxes", "proposed"
};

// `masks`: artifact of the masks stage, optional. Throws Error{Input}.
RunResults read_run_results(const std::filesystem::path& sfm, const std::optional<std::filesystem::path>& masks);

}  // namespace vitrine
