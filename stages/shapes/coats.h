// Which objects of the specular masks keep their paint: glazed, lacquered, clear-coated ones. Their view dependence
// (core/stereo/view_dependence) is that of paint.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "core/shape/shape_set.h"
#include "core/stereo/view_dependence.h"
#include "stages/shapes/objects.h"

namespace vitrine {

class CoatTest {
 public:
  // Reads the photos of the silhouettes once, reduced.
  CoatTest(const std::filesystem::path& sfm, std::span<const Silhouette> silhouettes);

  // Of an entry without parent, with its appendages; what `all` has in front hides it.
  std::optional<double> view_dependence_of(const ShapeSet& all, uint32_t entry) const;
  // Of an object that has no shape.
  std::optional<double> view_dependence_of(const MaskedObject& object) const;

 private:
  std::vector<LuminancePhoto> photos_;
  double spread_ = 0;
};

// The visual hull of an object of paint that has no shape: an entry of role Coat that is not exact; nothing where it has no
// faces.
ShapeSet hull_coat(const MaskedObject& object);

}  // namespace vitrine
