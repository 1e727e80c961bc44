// Cost estimate of the mesh stage.
#include <cmath>

#include "stages/mesh/mesh.h"

namespace vitrine {

StageCost mesh_cost(const CostTerms& t) {
  const double scale = std::pow(t.number("mesh.resolution") / 256, 2), hulls = t.capture.masks ? 16 : 0;
  return stage_cost(8 + 4.5 * scale + hulls, 0.5, (t.capture.masks ? 1.5 : 1) * (100 + 150 * scale),
                    9e-5 * t.number("mesh.faces"));
}

}  // namespace vitrine
