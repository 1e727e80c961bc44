// Masks from a segmentation network that looks at one photo at a time (core/network). The photos then vote: the visual hull of
// the masks of a class is carried to all photos; where a photo and the hull disagree, the hull counts, with little confidence.
#pragma once

#include <functional>
#include <memory>

#include "stages/masks/mask_source.h"
#include "stages/masks/onnx/class_values.h"

namespace vitrine {

struct NetworkMasks {
  struct Class {
    bool asked = false, found = false;  // found: some pixel of some photo belongs
    bool voted = false;
    double agreement = 0;                       // mean overlap of the photos' masks and the hull's; 0 without a hull
    std::vector<std::vector<float>> value;      // [view][h,w]
    std::vector<std::vector<uint8_t>> doubted;  // [view][h,w] photo and hull disagree; empty without a vote
  };
  NetworkMasksConfig config;
  std::string sha256;
  std::vector<View> views;  // at the size of the masks
  std::array<Class, kMaskClassCount> classes;
};
// Throws Error{Input} as PhotoNetwork does. `classes`: those that are asked for.
std::shared_ptr<const NetworkMasks> network_masks(const NetworkMasksConfig& config, const MaskCapture& capture,
                                                  const std::filesystem::path& file, std::span<const MaskClass> classes,
                                                  const std::function<void(double)>& progress);

class NetworkSource final : public MaskSource {
 public:
  NetworkSource(std::shared_ptr<const NetworkMasks> masks, MaskClass kind) : masks_(std::move(masks)), kind_(kind) {}
  std::string_view name() const override { return "onnx"; }
  std::string_view trust() const override { return "detected"; }
  std::optional<SoftMask> at(size_t view) const override;
  void report(nlohmann::ordered_json& j) const override;

 private:
  std::shared_ptr<const NetworkMasks> masks_;
  MaskClass kind_;
};

}  // namespace vitrine
