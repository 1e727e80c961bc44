// Masks from a segmentation network that processes one photo at a time (core/observe/network). The photos then vote: the visual
// hull of the masks of a class is projected into all photos and replaces the mask where they disagree, with low confidence.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "core/observe/network/photo_network.h"
#include "stages/masks/mask_source.h"

namespace vitrine {

class Describer;

// What the numbers of the network mean, as declared: which channels are which class, what makes them probabilities, from which
// one on a pixel belongs.
// What the network's output is: logits of classes of their own (Sigmoid) or of which one holds (Softmax), probabilities, logits
// of which the largest counts (Argmax), or one label a pixel.
enum class NetworkActivation { Sigmoid, Softmax, Probability, Argmax, Labels };
inline constexpr std::array<std::string_view, 5> kNetworkActivationWords{"sigmoid", "softmax", "probability", "argmax", "labels"};

struct NetworkMasksConfig {
  NetworkInput input{};
  int outputs = 1;
  NetworkActivation activation = NetworkActivation::Sigmoid;
  std::vector<double> object{}, transparent{}, specular{}, ignore{};  // channels, or labels
  double threshold = 0.5;

  const std::vector<double>& channels_of(MaskClass kind) const;
  std::string problem() const;  // empty when the configuration is consistent
};
void describe(Describer& d, NetworkMasksConfig& c);

// Class probability [h,w] in [0,1], remapped so that the threshold becomes 1/2; values nearer to 0 or 1 than to the threshold
// become 0 or 1. Of several channels the largest counts, with softmax their sum. Throws Error{Input} when the output contains NaN
// or infinity.
std::vector<float> class_values(const NetworkOutput& out, const NetworkMasksConfig& config, std::span<const double> channels,
                                const std::string& where);

struct NetworkMasks {
  struct Class {
    bool requested = false, found = false;  // found: some pixel of some photo belongs to the class
    bool voted = false;
    double agreement = 0;                       // mean IoU of the photos' masks and the visual hull; 0 without a hull
    std::vector<std::vector<float>> value;      // [view][h,w]
    std::vector<std::vector<uint8_t>> doubted;  // [view][h,w] photo and hull disagree; empty without a vote
  };
  NetworkMasksConfig config;
  std::string sha256;
  std::vector<View> views;  // at mask size
  std::array<Class, kMaskClassCount> classes;
};
// Throws Error{Input} as PhotoNetwork does. `classes`: the requested ones.
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
