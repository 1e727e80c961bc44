// The image formation: an ordered list of passes, run forwards for a picture and backwards for gradients. The model owns the one
// set of options that all of its passes read; they may change from picture to picture, the back ends may not.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/render/model/pass.h"

namespace vitrine {

// Sums of zero for every surfel of the scene; no layer has taken part. ImageModel::backward() begins with it; who runs passes
// alone calls it before.
void start_statistics(const SplatScene& scene, Frame& frame);

class ImageModel {
 public:
  explicit ImageModel(const ImageOptions& options) : options_(options) {}

  const ImageOptions& options() const { return options_; }
  ImageOptions& options() { return options_; }

  // Appends a pass. Error{Internal}: it reads what no pass before it writes, writes what another does, or changes what one before
  // it has read.
  void add(std::unique_ptr<Pass> pass);
  template <class P, class... Arguments>
  P* emplace(Arguments&&... arguments) {
    auto pass = std::make_unique<P>(std::forward<Arguments>(arguments)...);
    P* const out = pass.get();
    add(std::move(pass));
    return out;
  }

  std::span<const std::unique_ptr<Pass>> passes() const { return passes_; }

  void forward(const SplatScene& scene, const View& view, Frame& frame) const { forward(scene, view, options_, frame); }
  // With other options than its own, for one picture.
  void forward(const SplatScene& scene, const View& view, const ImageOptions& options, Frame& frame) const;
  // Of the last forward(), with its options. Sets the frame's statistics of all layers.
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) const;

 private:
  ImageOptions options_;
  std::vector<std::unique_ptr<Pass>> passes_;
  std::vector<std::string> writer_, reader_;  // [part] the first pass that does; empty: none
};

}  // namespace vitrine
