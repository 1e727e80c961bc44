// Writes chosen frames of a film as PNG files: full size, upright, square pixels, with a cICP chunk (PNG, third edition) that
// names primaries and transfer curve, so that they are made linear like any photo. 8 bits per sample, or 16 if the film has more.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/intake/film/film_decoder.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct FrameFile {
  int64_t pts = 0;
  std::filesystem::path path;
};

struct WrittenFrame {
  std::optional<double> blur_px;  // at a longest side of at most 800 pixels (core/intake/photos/measures.h)
  bool textured = false;          // has corners
  Image8 thumbnail;               // sRGB
};

// Decodes the film once, up to the last frame of `files`, which are in order of time. `progress` receives the number of frames.
std::vector<WrittenFrame> write_film_frames(const FilmInfo& film, const std::vector<FrameFile>& files,
                                            const std::function<void(size_t)>& progress);

// `png` with a cICP chunk for RGB samples of full range. Throws Error{Internal} if it is no PNG.
std::string with_cicp(const std::string& png, const Cicp& color);

}  // namespace vitrine
