// Structure of a HEIF file (ISO/IEC 23008-12: HEIC, AVIF) without decoding: the boxes of ISO/IEC 14496-12 name the primary
// picture, its size, turn, colours, metadata and where its bytes are. Only boxes are read: size, colours and the reason for a
// refusal are available before any allocation, also where no decoder is built in.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/image/color_profile.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct HeifFile {
  std::string coding;              // item type of the primary picture: "hvc1", "av01", "grid", ...; empty: none found
  uint64_t width = 0, height = 0;  // as displayed: cropped ('clap') and turned ('irot'), which the decoder does
  unsigned bits = 8;               // per sample ('pixi')
  bool alpha = false;              // an auxiliary picture holds the alpha of the primary one
  std::optional<Cicp> nclx;        // primaries and transfer; matrix and range are those of RGB, as decoded
  std::string_view icc;            // bytes of the profile; empty: none
  std::string exif;                // "Exif\0\0" + TIFF structure; empty: none
  uint64_t needed_bytes = 0;       // file size that boxes and items require
  // Offsets of the four-letter types of references from one auxiliary picture to several others. libheif before 1.19 refuses
  // them ("Too many auxiliary image references"); phones write them for gain maps.
  std::vector<size_t> shared_auxiliaries;
};

// `bytes` may be the beginning of a file; boxes behind it are missing.
HeifFile heif_file(std::string_view bytes);

// Reason why the primary picture cannot be read, or empty. `bytes`: the whole file, `kind`: "a HEIC photo".
std::string heif_refusal(const HeifFile& file, std::string_view bytes, std::string_view kind);

// Decodes the primary picture as displayed, in the colours of the file, 3 or 4 (alpha) channels of 8 or 16 bits; the other output
// stays empty. Returns why it cannot be decoded and what helps; empty on success. `kind`: "a HEIC photo".
std::string decoded_heif(std::string_view bytes, std::string_view kind, Image8& out8, Image16& out16);

// `bytes` with the references at `shared_auxiliaries` renamed, so that they have no meaning.
std::string without_shared_auxiliaries(std::string_view bytes, const HeifFile& file);

}  // namespace vitrine
