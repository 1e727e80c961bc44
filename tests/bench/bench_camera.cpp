// Reading and writing COLMAP models: bytes per second, beside plain reading of the same files (read_file), which no parser can
// beat. Before a row is timed, what is read must equal what was written. Names: colmap/<direction>/<bin|txt>.
#include <benchmark/benchmark.h>

#include <memory>
#include <string>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "core/scene/camera/colmap_model.h"

namespace vitrine {
namespace {

constexpr size_t kImages = 100, kPointsPerImage = 4000, kTriangulated = 30000;
const char* const kParts[] = {"cameras", "images", "points3D"};

// A capture as COLMAP leaves it: a third of the features are triangulated, tracks of 4.4 on average.
ColmapModel bench_model() {
  Rng rng(1);
  ColmapModel m;
  m.cameras = {{1, 2, 1600, 1200, {1400.5, 800, 600, -0.02}}};
  for (uint32_t i = 0; i < kImages; ++i) {
    ColmapImage image;
    image.id = i + 1;
    image.rotation = normalized(Quatd{rng.normal(), rng.normal(), rng.normal(), rng.normal()});
    image.translation = {rng.normal(), rng.normal(), rng.normal()};
    image.camera_id = 1;
    image.name = "IMG_" + std::to_string(1000 + i) + ".jpg";
    for (size_t k = 0; k < kPointsPerImage; ++k)
      image.points.push_back({1600 * rng.uniform_double(), 1200 * rng.uniform_double(), kNoPoint3D});
    m.images.push_back(std::move(image));
  }
  std::vector<uint32_t> used(kImages, 0);
  for (uint64_t k = 0; k < kTriangulated; ++k) {
    ColmapPoint3D p;
    p.id = k + 1;
    p.position = {rng.normal(), rng.normal(), rng.normal()};
    p.srgb = {uint8_t(rng.below(256)), uint8_t(rng.below(256)), uint8_t(rng.below(256))};
    p.error_px = rng.uniform_double();
    const uint32_t first = rng.below(kImages), length = 2 + rng.below(6);
    for (uint32_t i = 0; i < length; ++i) {
      const uint32_t v = (first + i) % kImages;
      if (used[v] == kPointsPerImage) continue;
      m.images[v].points[used[v]].point3d_id = p.id;
      p.track.push_back({v + 1, used[v]++});
    }
    m.points.push_back(std::move(p));
  }
  return m;
}

// The model's files, written once per process and format, and proven to read back as they were.
struct Files {
  TemporaryFolder folder;
  ColmapModel model = bench_model();
  size_t bytes = 0;
  bool correct = false;

  explicit Files(ColmapFormat format) {
    write_colmap_model(folder.path(), model, format);
    for (const auto& entry : fs::directory_iterator(folder.path())) bytes += entry.file_size();
    correct = read_colmap_model(folder.path(), format) == model;
  }
};

Files& files_of(ColmapFormat format) {
  static Files binary(ColmapFormat::Binary), text(ColmapFormat::Text);
  return format == ColmapFormat::Binary ? binary : text;
}

template <class Body>
void measure(benchmark::State& state, ColmapFormat format, const Body& body) {
  Files& files = files_of(format);
  if (!files.correct) return state.SkipWithError("the model does not read back as it was written");
  for (auto _ : state) body(files);
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations()) * static_cast<int64_t>(files.bytes));
  state.counters["observations/s"] =
      benchmark::Counter(double(kImages * kPointsPerImage), benchmark::Counter::kIsIterationInvariantRate);
}

void read_model(benchmark::State& state, ColmapFormat format) {
  measure(state, format, [&](Files& files) { benchmark::DoNotOptimize(read_colmap_model(files.folder.path(), format)); });
}

void write_model(benchmark::State& state, ColmapFormat format) {
  TemporaryFolder target;
  measure(state, format, [&](Files& files) { write_colmap_model(target.path(), files.model, format); });
}

void read_bytes(benchmark::State& state, ColmapFormat format) {
  measure(state, format, [&](Files& files) {
    for (const char* part : kParts)
      benchmark::DoNotOptimize(
          read_file(files.folder.path() / (std::string(part) + (format == ColmapFormat::Binary ? ".bin" : ".txt"))));
  });
}

BENCHMARK_CAPTURE(read_model, bin, ColmapFormat::Binary)->Name("colmap/read/bin")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_model, txt, ColmapFormat::Text)->Name("colmap/read/txt")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_model, bin, ColmapFormat::Binary)->Name("colmap/write/bin")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_model, txt, ColmapFormat::Text)->Name("colmap/write/txt")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes, bin, ColmapFormat::Binary)->Name("colmap/limit_read/bin")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bytes, txt, ColmapFormat::Text)->Name("colmap/limit_read/txt")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vitrine
