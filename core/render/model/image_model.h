// Image formation as an ordered list of passes: forward renders a picture, backward computes gradients. The model owns the
// options that all of its passes read; options may change between pictures, back ends may not.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/render/model/pass.h"

namespace vitrine {

// Zeroes the statistics of every surfel and the took_part flags. ImageModel::backward() calls it first; callers that run passes
// individually must call it themselves.
void start_statistics(const SplatScene& scene, Frame& frame);

class ImageModel {
 public:
  explicit ImageModel(const ImageOptions& options) : options_(options) {}

  const ImageOptions& options() const { return options_; }
  ImageOptions& options() { return options_; }

  // Appends a pass. Error{Internal}: it reads a part that no earlier pass writes, writes a part of another pass, or changes a
  // part that an earlier pass has read.
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
  // Overrides the model's options for one picture.
  void forward(const SplatScene& scene, const View& view, const ImageOptions& options, Frame& frame) const;
  // Backward of the last forward(), with its options. Sets the frame's statistics of all layers.
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) const;

 private:
  ImageOptions options_;
  std::vector<std::unique_ptr<Pass>> passes_;
  std::vector<std::string> writer_, reader_;  // [part] name of the first pass that writes or reads it; empty: none
};

}  // namespace vitrine
