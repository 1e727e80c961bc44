// The masks for a person to judge: some photos as they are, with the classes painted in, and the confidence.
#pragma once

#include "stages/masks/outputs.h"

namespace vitrine {

// masks/contact_sheet.png; nothing when no class was kept. Reads the masks back from the output.
void write_contact_sheet(const MaskOutputDesc& desc, const MaskResults& results);

}  // namespace vitrine
