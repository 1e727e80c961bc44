// A part of a list of pictures (`--frames 10-19`), so that several machines share the work, and the pictures that other parts
// have finished. Frames are numbered from 0 in the order of the whole list; file names and seeds are those of the whole.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/artifact/manifest.h"

namespace vitrine {

struct FrameRange {
  size_t first = 0, last = 0;  // both included
  size_t count() const { return last - first + 1; }
};

// "10-19", "7"; "": all. Returns an error sentence, or empty.
std::string frames_problem(std::string_view text);
// Throws Error{Usage} if the text is wrong or names frames that a list of `total` does not have. total > 0
FrameRange frames_of(std::string_view text, size_t total);
// For summaries: ", frames 10 to 19 of 60"; empty for the whole list.
std::string part_text(const FrameRange& frames, size_t total);

// Finished artifacts in the store of a stage that differ from the one being made in the option `frames` alone.
class StoredFrames {
 public:
  // `scratch`: StageContext::scratch(), <store>/<stage>/<key>.scratch; `frames`: value of the option of that key.
  StoredFrames(const std::filesystem::path& scratch, std::string_view frames);
  // Links the files of one picture, `folder`/`stem`.{png,exr} and `folder`/layers/*/`stem`.exr, into `output`. False, and nothing
  // is written, if no artifact has them with the bytes of its manifest.
  bool take(const std::filesystem::path& folder, const std::string& stem, const std::filesystem::path& output) const;

 private:
  struct Part {
    std::filesystem::path entry;
    std::vector<OutputFile> files;
  };
  std::vector<Part> parts_;
};

}  // namespace vitrine
