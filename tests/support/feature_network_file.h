// A small feature network in the form that core/learn/loss/feature_network.h reads.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"

namespace vitrine::testing {

struct NetworkLayer {
  int number, in, out;
  std::vector<float> weights, bias;
};

// Two blocks: 3 -> 9 -> 8, pooling, 8 -> 6.
inline std::vector<NetworkLayer> small_network(uint64_t seed = 1) {
  std::vector<NetworkLayer> layers{{0, 3, 9, {}, {}}, {2, 9, 8, {}, {}}, {5, 8, 6, {}, {}}};
  Rng rng(seed);
  for (NetworkLayer& l : layers) {
    for (int i = 0; i < l.out * l.in * 9; ++i) l.weights.push_back(0.3f * rng.normal() / std::sqrt(float(l.in)));
    for (int i = 0; i < l.out; ++i) l.bias.push_back(0.3f * rng.normal());
  }
  return layers;
}

// `heads`: weights of LPIPS for the channels of each feature.
inline void write_network(const fs::path& path, const std::vector<NetworkLayer>& layers,
                          const std::vector<std::vector<float>>& heads = {}) {
  std::string header =
                  R"({"__metadata__":{"format":"pt"},"classifier.0.weight":{"dtype":"F16","shape":[1],"data_offsets":[0,2]})",
              data;
  for (const NetworkLayer& l : layers)
    for (const bool bias : {false, true}) {
      const auto& values = bias ? l.bias : l.weights;
      header += fmt::format(R"(,"features.{}.{}":{{"dtype":"F32","shape":{},"data_offsets":[{},{}]}})", l.number,
                            bias ? "bias" : "weight", bias ? fmt::format("[{}]", l.out) : fmt::format("[{},{},3,3]", l.out, l.in),
                            data.size(), data.size() + 4 * values.size());
      data.append(reinterpret_cast<const char*>(values.data()), 4 * values.size());
    }
  for (size_t t = 0; t < heads.size(); ++t) {
    header += fmt::format(R"(,"lin{}.model.1.weight":{{"dtype":"F32","shape":[1,{},1,1],"data_offsets":[{},{}]}})", t,
                          heads[t].size(), data.size(), data.size() + 4 * heads[t].size());
    data.append(reinterpret_cast<const char*>(heads[t].data()), 4 * heads[t].size());
  }
  header += "}";
  std::string length(8, '\0');
  for (size_t i = 0; i < 8; ++i) length[i] = char(header.size() >> (8 * i) & 255);
  write_file(path, length + header + data);
}

}  // namespace vitrine::testing
