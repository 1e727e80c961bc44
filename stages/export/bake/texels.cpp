#include "stages/export/bake/texels.h"

#include <cmath>
#include <vector>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

struct Level {
  int width, height;
  std::vector<float> values;  // [h, w, c]
  std::vector<uint8_t> known;
};

// Mean of the known texels of each 2 x 2 block.
Level coarser(const Level& fine, int channels) {
  Level out{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  const size_t n = size_t(out.width) * size_t(out.height), count = size_t(channels);
  out.values.assign(n * count, 0.f);
  out.known.assign(n, 0);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const size_t to = size_t(y) * size_t(out.width) + size_t(x);
      float weight = 0;
      for (int fy = 2 * y; fy < std::min(2 * y + 2, fine.height); ++fy)
        for (int fx = 2 * x; fx < std::min(2 * x + 2, fine.width); ++fx) {
          const size_t from = size_t(fy) * size_t(fine.width) + size_t(fx);
          if (!fine.known[from]) continue;
          ++weight;
          for (size_t c = 0; c < count; ++c) out.values[to * count + c] += fine.values[from * count + c];
        }
      if (weight == 0) continue;
      out.known[to] = 1;
      for (size_t c = 0; c < count; ++c) out.values[to * count + c] /= weight;
    }
  return out;
}

}  // namespace

void fill_gaps(Image8& image, std::span<const uint8_t> known) {
  VITRINE_CHECK(known.size() == image.pixel_count(), "one flag per texel");
  const auto count = size_t(image.channels());
  std::vector<Level> levels;
  levels.push_back({image.width(), image.height(), std::vector<float>(image.data().begin(), image.data().end()),
                    std::vector<uint8_t>(known.begin(), known.end())});
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(coarser(levels.back(), image.channels()));
  for (size_t l = levels.size() - 1; l-- > 0;) {
    Level& fine = levels[l];
    const Level& coarse = levels[l + 1];
    for (int y = 0; y < fine.height; ++y)
      for (int x = 0; x < fine.width; ++x) {
        const size_t to = size_t(y) * size_t(fine.width) + size_t(x);
        if (fine.known[to]) continue;
        const size_t from = size_t(y / 2) * size_t(coarse.width) + size_t(x / 2);
        for (size_t c = 0; c < count; ++c) fine.values[to * count + c] = coarse.values[from * count + c];
      }
  }
  for (size_t i = 0; i < image.data().size(); ++i)
    if (!known[i / count]) image.data()[i] = uint8_t(std::lround(levels[0].values[i]));
}

}  // namespace vitrine
