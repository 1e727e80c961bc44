#include "core/learn/loss/feature_network.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"

namespace vitrine {

std::map<std::string, Tensor> read_safetensors(const fs::path& path, const std::string& prefix) {
  constexpr uint64_t kMaxHeader = 100'000'000;  // limit of the format
  const auto fail = [&](const std::string& why) {
    return Error(
        ErrorKind::Input, "a weights file is unusable",
        {.where = path.string(), .why = why, .hint = "a safetensors file, see core/learn/loss/README.md", .code = "BAD_WEIGHTS"});
  };
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw fail("it cannot be opened");
  const auto size = static_cast<uint64_t>(in.tellg());
  in.seekg(0);
  unsigned char length_bytes[8] = {};
  in.read(reinterpret_cast<char*>(length_bytes), 8);
  uint64_t length = 0;
  for (int i = 7; i >= 0; --i) length = length << 8 | length_bytes[i];
  if (!in || length > kMaxHeader || length + 8 > size) throw fail("it is not a safetensors file, or cut short");
  std::string header(length, '\0');
  in.read(header.data(), static_cast<std::streamsize>(length));
  const uint64_t data_begin = 8 + length, data_size = size - data_begin;
  std::map<std::string, Tensor> tensors;
  uint64_t taken = 0;  // tensors must not overlap: otherwise a small file could fill any memory
  try {
    const auto json = nlohmann::json::parse(header);
    for (const auto& [name, entry] : json.items()) {
      if (!name.starts_with(prefix)) continue;
      if (entry.at("dtype") != "F32") throw fail(fmt::format("{} is not float32", name));
      Tensor tensor;
      uint64_t count = 1;
      for (const auto& side : entry.at("shape")) {
        tensor.shape.push_back(side.get<uint64_t>());
        if (tensor.shape.back() == 0 || tensor.shape.back() > data_size)
          throw fail(fmt::format("{} has a senseless shape", name));
        count *= tensor.shape.back();
        if (count > data_size) throw fail(fmt::format("{} is larger than the file", name));
      }
      const auto begin = entry.at("data_offsets").at(0).get<uint64_t>(), end = entry.at("data_offsets").at(1).get<uint64_t>();
      if (begin > end || end > data_size || end - begin != count * sizeof(float))
        throw fail(fmt::format("the bytes of {} do not lie in the file, or do not fit its shape", name));
      taken += end - begin;
      if (taken > data_size) throw fail("its tensors overlap");
      tensor.values.resize(count);
      in.seekg(static_cast<std::streamoff>(data_begin + begin));
      in.read(reinterpret_cast<char*>(tensor.values.data()), static_cast<std::streamsize>(end - begin));
      if (!in) throw fail("it cannot be read");
      for (float v : tensor.values)
        if (!std::isfinite(v)) throw fail(fmt::format("{} holds a value that is no number", name));
      tensors.emplace(name, std::move(tensor));
    }
  } catch (const nlohmann::json::exception& e) {
    throw fail(cause_of(e));
  }
  return tensors;
}

}  // namespace vitrine
