// Serialisation of checkpoints: plain values and arrays in a fixed order. The same code reads and writes, so that the formats
// match. Reading checks every size: damaged bytes cause an Error, never a crash.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

class Archive {
 public:
  Archive() = default;  // writes
  explicit Archive(std::string_view bytes) : reads_(true), source_(bytes) {}

  bool reads() const { return reads_; }
  const std::string& bytes() const { return bytes_; }  // written
  bool at_end() const { return source_.empty(); }      // everything is read

  template <class T>
  void value(T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    move(&v, sizeof v);
  }
  template <class T>
  void array(std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    auto size = static_cast<uint64_t>(values.size());
    value(size);
    if (reads_ && size > source_.size() / sizeof(T)) fail();
    values.resize(size);
    move(values.data(), size * sizeof(T));
  }
  void layer(SplatLayer& layer) {
    LayerKind kind = layer.kind();
    int sh_degree = layer.sh_degree();
    auto size = static_cast<uint64_t>(layer.size());
    value(kind), value(sh_degree), value(size);
    if (reads_) {
      if (static_cast<size_t>(kind) >= kAllLayers.size() || sh_degree < 0 || sh_degree > 3 || size > source_.size()) fail();
      layer = SplatLayer(kind, sh_degree, size);
    }
    for (const AttributeRow& r : kAttributes) move(layer.values(r.id).data(), layer.values(r.id).size_bytes());
  }
  // Throws Error{Input}: the data is invalid.
  [[noreturn]] static void fail(const std::string& why = "its sizes do not add up") {
    throw Error(ErrorKind::Input, "a checkpoint is damaged",
                {.why = why, .hint = "the stage begins anew without it", .code = "BAD_CHECKPOINT"});
  }

 private:
  void move(void* data, size_t size) {
    if (!reads_) {
      bytes_.append(static_cast<const char*>(data), size);
      return;
    }
    if (size > source_.size()) fail();
    if (size > 0) std::memcpy(data, source_.data(), size);
    source_.remove_prefix(size);
  }

  bool reads_ = false;
  std::string bytes_;
  std::string_view source_;  // remaining bytes
};

}  // namespace vitrine
