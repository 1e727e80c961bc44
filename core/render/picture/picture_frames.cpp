#include "core/render/picture/picture_frames.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/hash.h"

namespace vitrine {

namespace {

constexpr std::string_view kTerm = "option.frames";

std::optional<size_t> number(std::string_view text) {
  size_t value = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
  return ec == std::errc() && end == text.data() + text.size() && !text.empty() ? std::optional(value) : std::nullopt;
}

std::optional<FrameRange> range_of(std::string_view text) {
  const size_t dash = text.find('-');
  const auto first = number(text.substr(0, dash));
  const auto last = dash == std::string_view::npos ? first : number(text.substr(dash + 1));
  return first && last ? std::optional(FrameRange{*first, *last}) : std::nullopt;
}

// As `canonical_value` writes the option into the key: the terms differ in nothing else.
std::string key_with(KeyTerms terms, std::string_view frames) {
  terms[std::string(kTerm)] = fmt::format("\"{}\"", frames);
  return key_of(terms);
}

bool is_of_picture(const fs::path& file, const fs::path& folder, const std::string& stem) {
  const fs::path path = file.lexically_relative(folder);
  if (path == stem + ".png" || path == stem + ".exr") return true;
  auto part = path.begin();
  if (part == path.end() || *part != "layers" || ++part == path.end()) return false;
  return path == fs::path("layers") / *part / (stem + ".exr");
}

bool is_intact(const fs::path& path, const OutputFile& file) {
  std::error_code ec;
  return fs::file_size(path, ec) == file.bytes && !ec && digest_file(path).hex() == file.digest;
}

}  // namespace

std::string frames_problem(std::string_view text) {
  if (text.empty()) return "";
  const auto range = range_of(text);
  if (!range) return fmt::format("frames must be one number or two, like 7 or 10-19, got \"{}\"", text);
  if (range->first > range->last)
    return fmt::format("frames {} end before they begin: write {}-{}", text, range->last, range->first);
  return "";
}

FrameRange frames_of(std::string_view text, size_t total) {
  VITRINE_CHECK(total > 0, "no pictures");
  if (text.empty()) return {0, total - 1};
  std::string problem = frames_problem(text);
  if (!problem.empty()) throw Error(ErrorKind::Usage, std::move(problem), {.hint = "--frames 10-19", .code = "USAGE"});
  const FrameRange range = *range_of(text);
  if (range.last >= total)
    throw Error(ErrorKind::Usage, fmt::format("there is no frame {}", range.last),
                {.where = fmt::format("--frames {}", text),
                 .why = total == 1 ? std::string("there is one picture, frame 0")
                                   : fmt::format("there are {} pictures, frames 0 to {}", total, total - 1),
                 .hint = fmt::format("--frames {}-{}", std::min(range.first, total - 1), total - 1),
                 .code = "NO_FRAME"});
  return range;
}

std::string part_text(const FrameRange& frames, size_t total) {
  if (frames.count() == total) return "";
  if (frames.count() == 1) return fmt::format(", frame {} of {}", frames.first, total);
  return fmt::format(", frames {} to {} of {}", frames.first, frames.last, total);
}

StoredFrames::StoredFrames(const fs::path& scratch, std::string_view frames) {
  const fs::path stage = scratch.parent_path();
  const std::string key = scratch.stem().string();
  std::error_code ec;
  std::vector<fs::path> folders;
  for (const auto& e : fs::directory_iterator(stage, ec))
    if (e.is_directory(ec) && e.path().filename() != key && fs::exists(e.path() / kManifestName, ec)) folders.push_back(e.path());
  std::ranges::sort(folders);
  for (const fs::path& folder : folders) {
    try {
      const std::string file = (folder / kManifestName).string();
      const Manifest m = manifest_from_json(read_file(file), file);
      if (m.terms.contains(std::string(kTerm)) && key_with(m.terms, frames) == key) parts_.push_back({folder, m.outputs});
    } catch (const Error&) {
      // A damaged artifact has no frames; the stage computes them.
    }
  }
}

bool StoredFrames::take(const fs::path& folder, const std::string& stem, const fs::path& output) const {
  for (const Part& part : parts_) {
    std::vector<std::string> files;
    const bool intact = std::ranges::all_of(part.files, [&](const OutputFile& f) {
      if (!is_of_picture(f.path, folder, stem)) return true;
      files.push_back(f.path);
      return is_intact(part.entry / f.path, f);
    });
    if (!intact || files.empty()) continue;
    for (const std::string& file : files) link_or_copy(part.entry / file, output / file);
    return true;
  }
  return false;
}

}  // namespace vitrine
