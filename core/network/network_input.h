// What goes into a network that looks at one photo: the size, and which number of which colour stands where. Every stage with
// such a network declares these options among its own.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace vitrine {

class Describer;

struct NetworkInput {
  int width = 0, height = 0;
  int max_side = 384;
  int multiple = 32;
  std::string layout = "nchw";
  std::string channels = "rgb";
  std::vector<double> mean{0, 0, 0};
  std::vector<double> deviation{1, 1, 1};
  std::string sha256 = "";

  // Size at which a photo of width x height goes in.
  std::pair<int, int> size_of(int photo_width, int photo_height) const;
  // What contradicts itself, in words that begin with `prefix` ("onnx."); empty when nothing does.
  std::string problem(const std::string& prefix) const;
};
// Inside the describe() of the options that hold it: no group of its own.
void describe_input(Describer& d, NetworkInput& c);

}  // namespace vitrine
