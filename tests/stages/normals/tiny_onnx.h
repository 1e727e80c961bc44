// ONNX files of one operator, written byte by byte: networks whose answer is known, and some that nobody can run.
#pragma once

#include <string>
#include <string_view>

namespace vitrine::test {

inline std::string varint(uint64_t value) {
  std::string out;
  for (; value >= 0x80; value >>= 7) out += char(value | 0x80);
  return out + char(value);
}
inline std::string number(int field, uint64_t value) { return varint(uint64_t(field) << 3) + varint(value); }
inline std::string bytes(int field, std::string_view content) {
  return varint(uint64_t(field) << 3 | 2) + varint(content.size()) + std::string(content);
}

// ValueInfoProto of a float tensor 1 x 3 x height x width.
inline std::string picture(std::string_view name, int width, int height) {
  std::string shape;
  for (int size : {1, 3, height, width}) shape += bytes(1, number(1, uint64_t(size)));
  return bytes(1, name) + bytes(2, bytes(1, number(1, 1) + bytes(2, shape)));
}

// photo -> `op` -> normal.
inline std::string one_operator_network(std::string_view op, int width, int height) {
  const std::string node = bytes(1, "photo") + bytes(2, "normal") + bytes(3, "only") + bytes(4, op);
  const std::string graph =
      bytes(1, node) + bytes(2, "g") + bytes(11, picture("photo", width, height)) + bytes(12, picture("normal", width, height));
  return number(1, 7) + bytes(7, graph) + bytes(8, number(2, 12));  // ir_version 7, opset 12
}

}  // namespace vitrine::test
