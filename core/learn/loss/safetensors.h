// Reader of float32 tensors from a safetensors file: 8 bytes length of the header (little endian), a JSON header {"name":
// {"dtype": "F32", "shape": [...], "data_offsets": [begin, end]}, ...}, then the bytes of the tensors.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace vitrine {

struct Tensor {
  std::vector<size_t> shape;
  std::vector<float> values;
};
// Reads the tensors whose name starts with `prefix`. Throws Error{Input} with file and cause.
std::map<std::string, Tensor> read_safetensors(const std::filesystem::path& path, const std::string& prefix);

}  // namespace vitrine
