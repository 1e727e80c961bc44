#include "core/model/display_pass.h"

#include <algorithm>
#include <vector>

#include "core/base/parallel.h"
#include "core/math/color.h"

namespace vitrine {

namespace {

constexpr size_t kGrain = 8192;
constexpr float kSlopeFloor = 1e-4f;  // the transfer's own slope is bounded there; algorithms 0
constexpr int kTableSize = 4096;

// pow() for every pixel and channel costs more than the losses, so the transfer is read from a table with linear
// interpolation in sqrt(l), where it is smooth: |error| < 2e-6 and the slope is within 1e-3 of the exact one.
struct TransferTable {
  std::vector<float> value, slope;
  TransferTable() : value(kTableSize + 2), slope(kTableSize + 2) {
    for (int i = 0; i < kTableSize + 2; ++i) {
      const double root = double(i) / kTableSize, l = root * root;
      value[static_cast<size_t>(i)] = static_cast<float>(srgb_from_linear(l));
      slope[static_cast<size_t>(i)] = static_cast<float>(srgb_from_linear_slope(std::max(l, double(kSlopeFloor))));
    }
  }
  static float lookup(const std::vector<float>& table, float root) {
    const float position = root * kTableSize;
    const int i = static_cast<int>(position);
    const float f = position - static_cast<float>(i);
    return table[static_cast<size_t>(i)] + f * (table[static_cast<size_t>(i) + 1] - table[static_cast<size_t>(i)]);
  }
};
const TransferTable& transfer_table() {
  static const TransferTable table;
  return table;
}

// Runs body(begin, end, gain) over the pieces of the three planes.
template <class Body>
void for_pieces(const Frame& frame, const Body& body) {
  const size_t pixels = frame.pixel_count();
  for (size_t c = 0; c < 3; ++c) {
    const float gain = static_cast<float>(frame.view->gain[c]);
    parallel_chunks(pixels, kGrain, [&](size_t, size_t begin, size_t end) { body(c * pixels + begin, c * pixels + end, gain); });
  }
}

}  // namespace

void DisplayPass::forward(const SplatScene&, Frame& frame) {
  frame.srgb.resize(frame.linear.size());
  frame.grad_srgb.assign(frame.linear.size(), 0.f);
  const TransferTable& table = transfer_table();
  for_pieces(frame, [&](size_t begin, size_t end, float gain) {
    for (size_t i = begin; i < end; ++i) {
      const float l = std::min(std::max(gain * frame.linear[i], 0.f), 1.f);
      frame.srgb[i] = TransferTable::lookup(table.value, std::sqrt(l));
    }
  });
}

void DisplayPass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  frame.grad_linear.resize(frame.linear.size());
  const TransferTable& table = transfer_table();
  for_pieces(frame, [&](size_t begin, size_t end, float gain) {
    for (size_t i = begin; i < end; ++i) {
      const float l = gain * frame.linear[i], g = frame.grad_srgb[i];
      const bool blind = (l > 1.f && g < 0.f) || (l < 0.f && g > 0.f);
      const float clamped = std::min(std::max(l, 0.f), 1.f);
      frame.grad_linear[i] = blind ? 0.f : g * gain * TransferTable::lookup(table.slope, std::sqrt(clamped));
    }
  });
}

}  // namespace vitrine
