// How long a stage will take, and what memory and disk: what a stage is asked (CostTerms) and answers (StageCost), as JSON in
// `vitrine-<stage> --cost`. Every stage holds its own formula, a sum of a few terms whose coefficients were measured
// (pipeline/README.md, "What a run costs"); the pipeline adds the answers.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vitrine {

struct CaptureSize {
  size_t photos = 0;
  double photographed_mpx = 0;  // all photos together
  double aspect = 0.75;         // short over long side
  double longest_px = 0;        // of a typical photo
  double texture = 0;           // share of 16 x 16 cells with a corner
  bool masks = false;           // given by the user: layers are trained
};

struct StageCost {
  double cpu_s = 0;
  double parallel = 0;  // share of cpu_s that more threads shorten
  size_t memory_bytes = 0, disk_bytes = 0;
  double seconds(int threads) const { return cpu_s * (1 - parallel + parallel / threads); }
};
StageCost stage_cost(double cpu_s, double parallel, double memory_mib, double disk_mib);

struct CostTerms {
  CaptureSize capture;
  int threads = 1;
  std::map<std::string, std::string> options;  // of the whole run: "mesh.faces", "input.truth"

  const std::string& text(const std::string& path) const;  // Error{Usage}: there is no such option
  double number(const std::string& path) const;
  bool is_given(const std::string& path) const;  // neither empty nor "none"
  // The smaller of an option and a limit, each by 0 = none.
  double limited(const std::string& path, double below) const;
  // Megapixels of one photo whose longest side is limited, by 0 = not.
  double mpx(double max_side) const;
  double photos() const { return double(capture.photos); }
};

std::string to_json(const std::vector<CostTerms>& terms);  // on one line
std::string to_json(const std::vector<StageCost>& costs);
std::vector<CostTerms> cost_terms_from_json(const std::string& json);  // Error{Usage}
std::optional<std::vector<StageCost>> costs_from_json(const std::string& json);

}  // namespace vitrine
