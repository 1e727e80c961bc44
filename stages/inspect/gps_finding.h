// GPS coordinates of the photos: whether the sfm stage can take scale and north from them.
#pragma once

#include <span>

#include "stages/inspect/findings.h"

namespace vitrine {

// nullopt: no photo has coordinates. The scale is expected from four photos on, if their horizontal spread determines it to 5 %
// at the usual error of a receiver under open sky; the poses, which are unknown yet, decide.
std::optional<Finding> gps_finding(std::span<const PhotoFacts> photos);

}  // namespace vitrine
