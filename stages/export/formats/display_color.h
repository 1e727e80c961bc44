// Spherical harmonics of linear radiance turned into spherical harmonics of the sRGB value, for viewers that take colour as
// display-referred. With L(d) = 0.5 + sum_k Y_k(d) h_k and e = the sRGB encoding, the DC is exact, the higher bands are scaled
// by the slope of e:   0.5 + Y_0 h'_0 = e(0.5 + Y_0 h_0),   h'_k = e'(L*) h_k.
// L* is the DC's radiance, but not less than the bands' own size (their root mean square over the sphere): near black the
// slope of e is 12.9, and a tangent there would turn a faint highlight into a blaze.
#pragma once

#include <span>

namespace vitrine {

// [k][rgb], DC first; in place.
void encode_sh_for_display(std::span<float> sh);

}  // namespace vitrine
