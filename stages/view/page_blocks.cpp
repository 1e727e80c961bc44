#include "stages/view/page_blocks.h"

#include <half.h>

#include <algorithm>

namespace vitrine {

namespace {
constexpr size_t kAlignment = 8;
constexpr float kHalfMax = 65504;
}  // namespace

uint16_t half_bits(float value) { return half(std::clamp(value, -kHalfMax, kHalfMax)).bits(); }

float rounded_half(float value, int mantissa_bits) {
  return half(std::clamp(value, -kHalfMax, kHalfMax)).round(static_cast<unsigned>(mantissa_bits));
}

void PageBlocks::add(std::string_view name, std::string_view type, const void* data, size_t count, size_t size, int width) {
  buffer_.resize((buffer_.size() + kAlignment - 1) / kAlignment * kAlignment, '\0');
  directory_.push_back({{"name", name}, {"type", type}, {"width", width}, {"offset", buffer_.size()}, {"count", count}});
  const auto* from = static_cast<const char*>(data);
  const size_t stride = size * static_cast<size_t>(width), items = stride == 0 ? 0 : count * size / stride;
  for (size_t plane = 0; plane < stride; ++plane)
    for (size_t i = 0; i < items; ++i) buffer_ += from[i * stride + plane];
}

void PageBlocks::floats(std::string_view name, std::span<const float> values, int width) {
  add(name, "f32", values.data(), values.size(), sizeof(float), width);
}
void PageBlocks::halves(std::string_view name, std::span<const float> values, int width, int mantissa_bits) {
  std::vector<uint16_t> bits(values.size());
  std::ranges::transform(values, bits.begin(), [&](float v) { return half_bits(rounded_half(v, mantissa_bits)); });
  add(name, "f16", bits.data(), bits.size(), sizeof(uint16_t), width);
}
void PageBlocks::bytes(std::string_view name, std::span<const uint8_t> values, int width) {
  add(name, "u8", values.data(), values.size(), 1, width);
}
void PageBlocks::words(std::string_view name, std::span<const uint16_t> values, int width) {
  add(name, "u16", values.data(), values.size(), sizeof(uint16_t), width);
}
void PageBlocks::indices(std::string_view name, std::span<const uint32_t> values, int width) {
  add(name, "u32", values.data(), values.size(), sizeof(uint32_t), width);
}

}  // namespace vitrine
