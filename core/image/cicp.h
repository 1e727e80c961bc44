// Coding-independent code points (ITU-T H.273): four numbers that name the primaries and the curve of a picture. PNG files have
// them in their cICP chunk, HDR pictures in their ICC profile.
#pragma once

#include "core/image/color_profile.h"

namespace vitrine {

struct Cicp {
  unsigned primaries = 2, transfer = 2, matrix = 0;  // 2 = not said
  bool full_range = true;
  bool is_hdr() const { return transfer == 16 || transfer == 18; }  // PQ, HLG
};

// nullptr for code points that name no colours of a still picture. HDR: 1 is the diffuse white of ITU-R BT.2408 (203 cd/m2 of PQ,
// 75 % of HLG).
ColorProfilePtr cicp_profile(const Cicp& cicp);

}  // namespace vitrine
