// What the numbers of a segmentation network mean, as declared: which channels are which class, what makes them probabilities,
// from which one on a pixel belongs.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/camera/mask_files.h"
#include "core/network/photo_network.h"

namespace vitrine {

class Describer;

struct NetworkMasksConfig {
  NetworkInput input{};
  int outputs = 1;
  std::string activation = "sigmoid";
  std::vector<double> object{}, transparent{}, specular{}, ignore{};  // channels, or labels
  double threshold = 0.5;
  bool soft = true;
  double confidence = 0.8;
  bool vote = true;
  int resolution = 96;

  const std::vector<double>& channels_of(MaskClass kind) const;
  std::string problem() const;  // empty when nothing contradicts itself
};
void describe(Describer& d, NetworkMasksConfig& c);

// [h,w] in [0,1]; 1/2 is the threshold, and what lies nearer to never or always than to it is 0 or 1. Of several channels the
// largest counts, with softmax their sum. Throws Error{Input} when the network gives what is no number.
std::vector<float> class_values(const NetworkOutput& out, const NetworkMasksConfig& config, std::span<const double> channels,
                                const std::string& where);

}  // namespace vitrine
