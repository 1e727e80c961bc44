#include "core/observe/network/photo_network.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

// Each operator was tested on OpenCV 4.6 against the output of the exporting program. Excluded although the importer accepts
// them: CumSum (crashes), attention made of MatMul and Softmax (wrong values), Clip with inputs, stand-alone BatchNormalization.
constexpr std::array kKnownGood = {"Abs",         "Add",
                                   "ArgMax",      "AveragePool",
                                   "Concat",      "Constant",
                                   "Conv",        "ConvTranspose",
                                   "Cos",         "DepthToSpace",
                                   "Div",         "Elu",
                                   "Erf",         "Exp",
                                   "Flatten",     "Floor",
                                   "Gemm",        "GlobalAveragePool",
                                   "HardSigmoid", "HardSwish",
                                   "Identity",    "InstanceNormalization",
                                   "LeakyRelu",   "Log",
                                   "LogSoftmax",  "Max",
                                   "MaxPool",     "Min",
                                   "Mul",         "Neg",
                                   "PRelu",       "Pad",
                                   "Pow",         "ReduceL2",
                                   "ReduceMax",   "ReduceMean",
                                   "ReduceSum",   "Relu",
                                   "Reshape",     "Resize",
                                   "Sigmoid",     "Sin",
                                   "Slice",       "Softmax",
                                   "Softplus",    "SpaceToDepth",
                                   "Split",       "Sqrt",
                                   "Squeeze",     "Sub",
                                   "Tanh",        "Transpose",
                                   "Unsqueeze",   "Upsample"};

// Minimal protobuf reader for nested messages: https://protobuf.dev/programming-guides/encoding
class Message {
 public:
  explicit Message(std::string_view bytes) : bytes_(bytes) {}

  // Calls `field(number, bytes)` for every length-delimited field; false when the message is damaged.
  bool each(const std::function<bool(uint64_t, std::string_view)>& field) const {
    size_t at = 0;
    const auto varint = [&]() -> std::optional<uint64_t> {
      uint64_t value = 0;
      for (int shift = 0; shift < 64 && at < bytes_.size(); shift += 7) {
        const auto byte = static_cast<unsigned char>(bytes_[at++]);
        value |= uint64_t(byte & 0x7f) << shift;
        if (byte < 0x80) return value;
      }
      return std::nullopt;
    };
    while (at < bytes_.size()) {
      const auto key = varint();
      if (!key) return false;
      uint64_t skip = 0;
      switch (*key & 7) {
        case 0:
          if (!varint()) return false;
          continue;
        case 1:
          skip = 8;
          break;
        case 5:
          skip = 4;
          break;
        case 2: {
          const auto size = varint();
          if (!size || *size > bytes_.size() - at) return false;
          if (!field(*key >> 3, bytes_.substr(at, *size))) return false;
          skip = *size;
          break;
        }
        default:
          return false;
      }
      if (skip > bytes_.size() - at) return false;
      at += skip;
    }
    return true;
  }

 private:
  std::string_view bytes_;
};

}  // namespace

std::set<std::string> onnx_operators(std::string_view model, const std::string& where) {
  constexpr uint64_t kGraph = 7, kNode = 1, kOperator = 4;  // field numbers in ModelProto, GraphProto, NodeProto
  std::set<std::string> found;
  const bool whole = Message(model).each([&](uint64_t number, std::string_view graph) {
    return number != kGraph || Message(graph).each([&](uint64_t part, std::string_view node) {
      return part != kNode || Message(node).each([&](uint64_t name, std::string_view text) {
        if (name == kOperator) found.emplace(text);
        return true;
      });
    });
  });
  if (!whole || found.empty())
    throw Error(ErrorKind::Input, "this is not an ONNX network",
                {.where = where,
                 .why = model.empty() ? "the file is empty"
                        : whole       ? "it holds no graph"
                                      : "the file is damaged or of another kind",
                 .hint = "export the network with torch.onnx.export(..., opset_version=12), or fetch it again",
                 .code = "NOT_ONNX"});
  return found;
}

std::vector<std::string> unsupported_operators(const std::set<std::string>& operators) {
  std::vector<std::string> missing;
  for (const std::string& name : operators)
    if (std::find(kKnownGood.begin(), kKnownGood.end(), name) == kKnownGood.end()) missing.push_back(name);
  return missing;
}

}  // namespace vitrine
