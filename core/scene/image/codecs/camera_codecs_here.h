// Entry points of the library of camera codecs, one source file each.
#pragma once

#include "core/scene/image/camera_codecs.h"

namespace vitrine {

std::string decode_heif(std::string_view bytes, bool alpha, Image8& out8, Image16& out16);
std::string heif_version();
std::string read_raw_facts(const std::string& path, RawFacts& out);
std::string decode_raw(const std::string& path, const RawRequest& request, ImageF& out);
std::string raw_version();

}  // namespace vitrine
