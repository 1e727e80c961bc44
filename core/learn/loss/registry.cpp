// One row per loss: to add one, write a file with make_<name>() and add a row here.
#include "core/learn/loss/loss.h"

namespace vitrine {

std::unique_ptr<Loss> make_l1_loss();
std::unique_ptr<Loss> make_dssim_loss();
std::unique_ptr<Loss> make_normal_consistency_loss();
std::unique_ptr<Loss> make_distortion_loss();
std::unique_ptr<Loss> make_opacity_loss();
std::unique_ptr<Loss> make_scale_loss();
std::unique_ptr<Loss> make_specular_mask_loss();
std::unique_ptr<Loss> make_transmission_mask_loss();
std::unique_ptr<Loss> make_object_mask_loss();
std::unique_ptr<Loss> make_first_hit_loss();
std::unique_ptr<Loss> make_monocular_normal_loss();

const std::vector<LossFactory>& loss_registry() {
  static const std::vector<LossFactory> rows{
      {"l1", "Mean absolute difference to the photo, display-referred.", 0.8f, make_l1_loss},
      {"dssim", "One minus the structural similarity to the photo.", 0.2f, make_dssim_loss},
      {"normal_consistency", "Surfel normals agree with the slope of the rendered depth.", 0.05f, make_normal_consistency_loss,
       0.4, 0.1},  // earlier, it freezes depths that are still wrong (stages/optimize/README.md)
      {"distortion", "Surfels along a ray gather at one depth.", 0.f, make_distortion_loss},
      {"opacity", "Mean opacity: frees surfels that the photos do not need.", 0.003f, make_opacity_loss},
      {"scale", "Mean scale: keeps surfels small where the photos do not need them large.", 0.003f, make_scale_loss},
      {"specular_mask", "Nothing reflects outside the specular mask, everything a little inside.", 0.02f,
       make_specular_mask_loss},
      {"transmission_mask", "Transmission agrees with the transparent mask.", 0.1f, make_transmission_mask_loss},
      // Only if the object is trained alone (stages/optimize/surroundings.h): otherwise it would remove the surroundings.
      {"object_mask", "Alpha agrees with the object mask, where the object is trained alone.", 0.3f, make_object_mask_loss},
      {"first_hit", "Transmitted and reflected layers stay off the surface that shows them.", 0.01f, make_first_hit_loss},
      {"monocular_normal", "Surfel normals agree with the normals stage.", 0.05f, make_monocular_normal_loss, 0, 0, 0.2},
      {"perceptual", "Features of a convolutional network agree with the photo's; needs `vgg`.", 0.01f,
       [] { return make_perceptual_loss(); }, 0.75},
  };
  return rows;
}

}  // namespace vitrine
