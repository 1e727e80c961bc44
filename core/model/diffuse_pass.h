// Rasterises the diffuse layer; its colour is the radiance that the following passes add to.
#pragma once

#include <memory>

#include "core/model/image_options.h"
#include "core/model/pass.h"
#include "core/render/renderer.h"

namespace vitrine {

class DiffusePass final : public Pass {
 public:
  explicit DiffusePass(const DiffuseOptions& options) : options_(options), renderer_(make_renderer(options.backend)) {}
  std::string_view name() const override { return "diffuse"; }
  DiffuseOptions& options() { return options_; }
  void set_sh_degree(int degree) { options_.sh_degree = degree; }
  void set_distortion(bool on) { options_.distortion = on; }
  const Renderer& renderer() const { return *renderer_; }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  DiffuseOptions options_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace vitrine
