#include "core/learn/optim/adam.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr size_t kChunk = 256;  // surfels per task
constexpr size_t kWidest = 45;  // floats of the widest attribute
static_assert([] {
  for (const AttributeRow& r : kAttributes)
    if (static_cast<size_t>(r.width) > kWidest) return false;
  return true;
}());

// Per-surfel factors repeated for every float of an attribute, so that the update is one flat, vectorisable loop.
struct Spread {
  float step[kChunk * kWidest], root[kChunk * kWidest], moves[kChunk * kWidest];
};

// Attributes of geometry and coverage, as opposed to appearance.
constexpr bool is_shape(Attribute a) {
  return a == Attribute::Mean || a == Attribute::Rotation || a == Attribute::LogScale || a == Attribute::Opacity;
}

bool finite(const SplatLayer& grad, size_t i) {
  float poison = 0;  // x * 0 is NaN for infinities and NaN, 0 otherwise
  for (const AttributeRow& r : kAttributes) {
    const float* g = grad.at(r.id, i);
    for (size_t c = 0, w = grad.width(r.id); c < w; ++c) poison += g[c] * 0.f;
  }
  return poison == 0.f;
}

}  // namespace

Adam::Adam(const SplatLayer& shape, const AdamDesc& desc)
    : desc_(desc),
      m_(shape.zeros_like()),
      v_(shape.zeros_like()),
      steps_(shape.size(), 0),
      corrections_(adam_corrections(desc)) {}

size_t Adam::step(const SplatLayer& grad, const AttributeRates& rates, std::span<const uint8_t> active, SplatLayer& layer,
                  const StepFactors& factors) {
  const size_t n = layer.size();
  for (std::span<const float> f : {factors.all, factors.shape, factors.place})
    VITRINE_CHECK(f.empty() || f.size() == n, "{} surfels, {} factors", n, f.size());
  VITRINE_CHECK(grad.size() == n && steps_.size() == n && active.size() == n,
                "shapes differ: {} surfels, {} gradients, {} moments, {} flags", n, grad.size(), steps_.size(), active.size());
  const float b1 = static_cast<float>(desc_.beta1), b2 = static_cast<float>(desc_.beta2), epsilon = desc_.epsilon;
  std::vector<size_t> skipped(chunk_count(n, kChunk), 0);
  parallel_chunks(n, kChunk, [&](size_t chunk, size_t begin, size_t end) {
    const size_t count = end - begin;
    float c1[kChunk], c2[kChunk], moves[kChunk];
    bool any = false;
    for (size_t k = 0; k < count; ++k) {
      const size_t i = begin + k;
      c1[k] = c2[k] = moves[k] = 0;
      if (active[i] == 0) continue;
      if (!finite(grad, i)) {
        ++skipped[chunk];
        continue;
      }
      any = true;
      const size_t t = std::min<size_t>(++steps_[i], corrections_.first.size() - 1);
      c1[k] = corrections_.first[t];
      c2[k] = corrections_.second[t];
      moves[k] = 1;
    }
    if (!any) return;
    Spread spread;
    for (const AttributeRow& r : kAttributes) {
      const size_t width = layer.width(r.id);
      const float rate = rates[static_cast<size_t>(r.id)];
      if (width == 0 || rate == 0) continue;
      for (size_t k = 0; k < count; ++k) {
        float own_rate = rate;
        if (!factors.all.empty()) own_rate *= factors.all[begin + k];
        if (!factors.shape.empty() && is_shape(r.id)) own_rate *= factors.shape[begin + k];
        if (!factors.place.empty() && r.id == Attribute::Mean) own_rate *= factors.place[begin + k];
        std::fill_n(spread.step + k * width, width, own_rate * c1[k]);
        std::fill_n(spread.root + k * width, width, c2[k]);
        std::fill_n(spread.moves + k * width, width, moves[k]);
      }
      const float* __restrict gradient = grad.at(r.id, begin);
      float* __restrict m = m_.at(r.id, begin);
      float* __restrict v = v_.at(r.id, begin);
      float* __restrict x = layer.at(r.id, begin);
      for (size_t j = 0; j < count * width; ++j) {
        const float g = spread.moves[j] != 0 ? gradient[j] : 0.f;
        adam_update<float>(g, {spread.step[j], spread.root[j], spread.moves[j]}, b1, b2, epsilon, m[j], v[j], x[j]);
      }
    }
  });
  size_t total = 0;
  for (size_t s : skipped) total += s;
  return total;
}

void Adam::resize(size_t size) {
  m_.resize(size);
  v_.resize(size);
  steps_.resize(size, 0);
}

void Adam::forget(size_t surfel) {
  for (SplatLayer* moments : {&m_, &v_})
    for (const AttributeRow& r : kAttributes) std::fill_n(moments->at(r.id, surfel), moments->width(r.id), 0.f);
  steps_[surfel] = 0;
}

void Adam::keep_only(std::span<const uint32_t> kept) {
  keep_surfels(m_, kept);
  keep_surfels(v_, kept);
  for (size_t to = 0; to < kept.size(); ++to) steps_[to] = steps_[kept[to]];
  steps_.resize(kept.size());
}

void Adam::transfer(Archive& archive) {
  archive.layer(m_);
  archive.layer(v_);
  archive.array(steps_);
  if (m_.size() != v_.size() || steps_.size() != m_.size()) archive.fail("moments of different sizes");
}

void keep_surfels(SplatLayer& layer, std::span<const uint32_t> kept) {
  for (size_t to = 0; to < kept.size(); ++to) {
    VITRINE_CHECK(kept[to] >= to && kept[to] < layer.size(), "surfel {} cannot move to {}", kept[to], to);
    if (kept[to] != to) layer.copy_surfel(kept[to], to);
  }
  layer.resize(kept.size());
}

}  // namespace vitrine
