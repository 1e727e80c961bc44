// Thin glass or solid? A ball of glass shows the room upside down, where a bottle shows it straight on. Rays are sent through a
// closed shape both ways, to the large planes of the scene, which other photos colour; what the photos of the object look more
// like decides. What stands in the glass is not predicted: a paperweight with a picture in its foot stays undecided.
#pragma once

#include <optional>
#include <span>

#include "core/shape/shape.h"
#include "core/stereo/small_stereo.h"

namespace vitrine {

// Local correlation of the photos with the picture that rays straight on, and bent by Snell's law, would show; 1: the same.
struct GlassTrial {
  double straight = 0, bent = 0;
  bool solid() const;
};

class SolidTrial {
 public:
  // Of the photos of an sfm artifact that are trained on, reduced; one stereo for all objects.
  SolidTrial(const std::filesystem::path& sfm, const ViewSet& set, int holdout_every);

  // Of the photos that show most of the shape. `marked`: [view][h*w of views()] 1 where the photo shows the object; empty of
  // those that are held out. nullopt: stereo found too little, or too few pixels tell.
  std::optional<GlassTrial> trial(const Shape& shape, std::span<const std::vector<uint8_t>> marked) const;
  std::span<const View> views() const { return stereo_.views(); }

 private:
  SmallStereo stereo_;
};

}  // namespace vitrine
