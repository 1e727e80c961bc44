#include "core/scene/layers.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace vitrine {

void SplatLayer::fill(float value) {
  constexpr size_t kChunk = 1 << 16;  // floats
  for (auto& array : data_)
    parallel_chunks(array.size(), kChunk,
                    [&](size_t, size_t begin, size_t end) { std::fill(array.data() + begin, array.data() + end, value); });
}

}  // namespace vitrine
