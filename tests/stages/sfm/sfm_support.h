// For tests of the sfm stage: an ingest artifact made from a folder of pictures, and a context that records what the stage says.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "stages/stage.h"

namespace vitrine {

// Writes ingest/photos.json, linear EXRs and 8-bit copies for the named pictures of `folder`.
inline std::vector<Photo> make_ingest(const fs::path& folder, const fs::path& out, int max_side = 0) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Photo> photos(files.size());
  make_folders(out / "ingest" / "linear");
  make_folders(out / "ingest" / "ldr");
  parallel_for(files.size(), 1, [&](size_t i) {
    ImageF linear = linear_from_srgb_image(read_srgb(files[i]));
    Photo& p = photos[i];
    p.original_width = linear.width(), p.original_height = linear.height();
    const Intrinsics size = Intrinsics{linear.width(), linear.height(), 1, 1, 0, 0}.limited_to(max_side);
    if (size.width != linear.width() || size.height != linear.height()) linear = resized(linear, size.width, size.height);
    p.name = p.source = files[i].filename().string();
    p.stem = files[i].stem().string();
    p.width = linear.width(), p.height = linear.height();
    write_exr_rgb(ingested_linear_path(out, p), linear);
    write_ldr(ingested_ldr_path(out, p), srgb8_from_linear(linear));
  });
  write_photo_list(out, photos);
  return photos;
}

class RecordingContext : public StageContext {
 public:
  RecordingContext(std::map<std::string, fs::path> inputs, fs::path folder, int threads = 2)
      : inputs_(std::move(inputs)), output_(folder / "out"), scratch_(folder / "scratch"), threads_(threads) {
    make_folders(output_);
    make_folders(scratch_);
    set_thread_limit(threads);
  }
  fs::path input(std::string_view name) const override { return inputs_.at(std::string(name)); }
  std::optional<fs::path> optional_input(std::string_view name) const override {
    const auto found = inputs_.find(std::string(name));
    return found == inputs_.end() ? std::nullopt : std::optional(found->second);
  }
  const fs::path& output() const override { return output_; }
  const fs::path& scratch() const override { return scratch_; }
  int threads() const override { return threads_; }
  size_t max_memory_bytes() const override { return 0; }
  void progress(const Progress& p) override { fractions.push_back(p.fraction); }
  void metric(std::string_view name, double value) override { metrics[std::string(name)] = value; }
  void warning(std::string_view code, std::string_view text) override {
    warnings.push_back(std::string(code) + " " + std::string(text));
  }
  void summary(std::string_view text) override { last_summary = text; }
  void timing(std::string_view name, double seconds) override { timings[std::string(name)] += seconds; }

  std::map<std::string, double> metrics, timings;
  std::vector<std::string> warnings;
  std::vector<double> fractions;
  std::string last_summary;

 private:
  std::map<std::string, fs::path> inputs_;
  fs::path output_, scratch_;
  int threads_;
};

}  // namespace vitrine
