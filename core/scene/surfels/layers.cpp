#include "core/scene/surfels/layers.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

void SplatLayer::fill(float value) {
  constexpr size_t kChunk = 1 << 16;  // floats
  for (auto& array : data_)
    parallel_chunks(array.size(), kChunk,
                    [&](size_t, size_t begin, size_t end) { std::fill(array.data() + begin, array.data() + end, value); });
}

bool is_glass(const SplatLayer& diffuse, size_t i) { return sigmoid(*diffuse.at(Attribute::Transmission, i)) > 0.5f; }

}  // namespace vitrine
