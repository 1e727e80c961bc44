// The pixels of known mirrors, formed anew from an opaque scene that was trained with the mirrors as surfels:
//
//   L(pixel) = tint_o / n  sum over n rays  [C(ray) + T(ray) E(direction)]
//
// ray: mirrored at the shape of object o at a place of the pixel; C, T: what the surfels that are not of o send and let through;
// E: a far field, linear radiance of a direction, solved from training photos by
//   E <- max(0, E + 1.3 sum(f w e) / sum(f w F)),  e = photo - L,  w = 1 / max(photo, .02),  f = dL/dE of the texel, F = its sum
// over the pixel (simultaneous algebraic reconstruction, Andersen and Kak 1984). A clipped pixel that is predicted brighter has
// e = 0. tint: least squares over pixels that are not clipped, alternating. Pixels that show no object say what they see of the
// far field straight on, with tint 1.
#pragma once

#include <filesystem>
#include <optional>

#include "core/foundation/base/json.h"

namespace vitrine {

struct MirrorOracleDesc {
  std::filesystem::path sfm, objects, opaque;    // artifacts
  std::optional<std::filesystem::path> trained;  // with all layers
  std::optional<std::filesystem::path> truth;    // its mesh.ply in place of shapes
  bool trained_shapes = false;                   // those that training left, not those that the objects stage found
  int rays = 3, rounds = 10, texels = 128, sh_degree = 0;
};

// PSNR pooled over held-out pixels whose label is a mirror of exact shape, by object and of all: "opaque", "trained", "oracle"
// and the means of pictures "opaque+trained", "opaque+oracle", "all"; and "train": the oracle's on photos that it was solved
// with.
nlohmann::ordered_json mirror_oracle(const MirrorOracleDesc& desc);

}  // namespace vitrine
