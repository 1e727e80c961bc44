// One photo in several files: cameras write raw and JPEG of the same name, phones HEIC and JPEG, and people keep what they
// developed from a raw file in the same folder.
#pragma once

#include <string>

#include "core/intake/photos/photo_files.h"

namespace vitrine {

// Whether a file with this lower-case extension (".heic") is a HEIC or AVIF picture by its name.
bool has_heif_extension(const std::string& extension);

// Of files in one folder that differ only in their extension, and of which one is raw or HEIC, one stays in `folder.photos`:
// TIFF, PNG, EXR (developed by hand) before raw, HEIC and JPEG. Raw and HEIC that this build cannot decode come last. The others
// move to `folder.versions`. Files whose EXIF times differ are different photos.
void leave_out_versions(PhotoFolder& folder);

}  // namespace vitrine
