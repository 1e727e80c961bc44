// The objects of one scene standing in another: the truth of a composition (vitrine compose).
#pragma once

#include "sample_data/generate/scene.h"

namespace vitrine::generate {

// Where the origin of the guest's frame stands in the host: scaled, then turned about the vertical, then moved along the ground.
struct GuestPlace {
  float x = 0, y = 0;  // metres
  float turn_rad = 0;
  float scale = 1;
};

// "X,Y,DEGREES,SCALE"; throws Error{Usage} for anything else.
GuestPlace guest_place(const std::string& text);

// Adds the parts of `guest` that are objects, with textures and materials, to `host`. They alone are objects of the host then, so
// that truth/mask/object shows the guest. Lamps, views and light stay those of the host.
void add_guest(Scene& host, const Scene& guest, const GuestPlace& place);

}  // namespace vitrine::generate
