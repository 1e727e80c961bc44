// The one place that decides the role of an object: glass by its class of masks; of what the specular masks mark, paint under a
// clear coat looks alike from everywhere, and what a mirror shows changes with the view (core/observe/stereo/view_dependence).
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/objects/object_set.h"
#include "core/observe/stereo/view_dependence.h"
#include "stages/objects/masked_objects.h"

namespace vitrine {

class RoleTest {
 public:
  // `silhouettes`: of the specular masks. Reads their photos once, reduced.
  RoleTest(const std::filesystem::path& sfm, std::span<const Silhouette> silhouettes);

  // Of the surface of an object's shapes; opaque shapes of `all` in front of it hide it. nullopt: too few photos see it.
  std::optional<double> view_dependence(const ShapeSet& all, uint16_t object) const;
  // Of an object whose shape is a visual hull.
  std::optional<double> view_dependence(const MaskedObject& object) const;

 private:
  std::vector<LuminancePhoto> photos_;
  double spread_ = 0;
};

// `exact`: its shape is known better than a visual hull; then what too few photos see is a mirror, else a coat, which keeps its
// surfels. `coat_below`: view dependence of a mirror, at least.
ObjectRole object_role_of(MaskClass kind, const std::optional<double>& view_dependence, bool exact, double coat_below);

}  // namespace vitrine
