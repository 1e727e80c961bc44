// The bytes of a checkpoint: plain values and arrays in a fixed order. The reader checks every size, so that damaged bytes
// are an Error, never a crash.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/error.h"
#include "core/scene/layers.h"

namespace vitrine {

class ArchiveWriter {
 public:
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&v), sizeof v);
  }
  template <class T>
  void array(std::span<const T> values) {
    value(static_cast<uint64_t>(values.size()));
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  void layer(const SplatLayer& layer) {
    value(layer.kind());
    value(layer.sh_degree());
    value(static_cast<uint64_t>(layer.size()));
    for (const AttributeRow& r : kAttributes) array(layer.values(r.id));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class ArchiveReader {
 public:
  explicit ArchiveReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  void value(T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&v, take(sizeof v), sizeof v);
  }
  template <class T>
  void array(std::vector<T>& values) {
    uint64_t size = 0;
    value(size);
    if (size > bytes_.size() / sizeof(T)) fail();
    values.resize(size);
    if (size > 0) std::memcpy(values.data(), take(size * sizeof(T)), size * sizeof(T));
  }
  void layer(SplatLayer& layer) {
    LayerKind kind{};
    int sh_degree = 0;
    uint64_t size = 0;
    value(kind);
    value(sh_degree);
    value(size);
    if (static_cast<size_t>(kind) >= kAllLayers.size() || sh_degree < 0 || sh_degree > 3 || size > bytes_.size()) fail();
    layer = SplatLayer(kind, sh_degree, size);
    for (const AttributeRow& r : kAttributes) {
      std::vector<float> values;
      array(values);
      if (values.size() != layer.values(r.id).size()) fail();
      std::copy(values.begin(), values.end(), layer.values(r.id).begin());
    }
  }
  bool at_end() const { return position_ == bytes_.size(); }
  // Throws Error{Input}: what was read makes no sense.
  [[noreturn]] static void fail(const std::string& why = "its sizes do not add up") {
    throw Error(ErrorKind::Input, "a checkpoint is damaged",
                {.why = why, .hint = "the stage begins anew without it", .code = "BAD_CHECKPOINT"});
  }

 private:
  const char* take(size_t size) {
    if (size > bytes_.size() - position_) fail();
    const char* p = bytes_.data() + position_;
    position_ += size;
    return p;
  }
  std::string_view bytes_;
  size_t position_ = 0;
};

}  // namespace vitrine
