// Cost estimate of a stage: CPU time, memory, disk. `vitrine-<stage> --cost` reads CostTerms and prints StageCost, both as JSON.
// Each stage defines its own formula, a sum of a few terms with measured coefficients (pipeline/README.md, "What a run costs");
// the pipeline adds the estimates up.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vitrine {

struct CaptureSize {
  size_t photos = 0;
  double photographed_mpx = 0;  // sum over all photos
  double aspect = 0.75;         // short side over long side
  double longest_px = 0;        // longest side of a typical photo
  double texture = 0;           // fraction of 16 x 16 cells with a corner
  bool masks = false;           // masks are given by the user: reflection and transmittance layers are trained
};

struct StageCost {
  double cpu_s = 0;
  double parallel = 0;  // fraction of cpu_s that scales with the number of threads
  size_t memory_bytes = 0, disk_bytes = 0;
  double seconds(int threads) const { return cpu_s * (1 - parallel + parallel / threads); }
};
StageCost stage_cost(double cpu_s, double parallel, double memory_mib, double disk_mib);

struct CostTerms {
  CaptureSize capture;
  int threads = 1;
  std::map<std::string, std::string> options;  // of the whole run: "mesh.faces", "input.truth"

  const std::string& text(const std::string& path) const;  // throws Error{Usage} if there is no such option
  double number(const std::string& path) const;
  bool is_given(const std::string& path) const;  // neither empty nor "none"
  // Minimum of an option and a limit; 0 means no limit for either.
  double limited(const std::string& path, double below) const;
  // Megapixels of one photo whose longest side is limited to max_side; 0: no limit.
  double mpx(double max_side) const;
  double photos() const { return double(capture.photos); }
};

std::string to_json(const std::vector<CostTerms>& terms);  // one line
std::string to_json(const std::vector<StageCost>& costs);
std::vector<CostTerms> cost_terms_from_json(const std::string& json);  // Error{Usage}
std::optional<std::vector<StageCost>> costs_from_json(const std::string& json);

}  // namespace vitrine
