// Files of known shapes: a JSON document, and a mesh beside it.
#include "core/base/file.h"
#include "core/base/json.h"
#include "core/shape/registry.h"
#include "core/shape/shape_file.h"
#include "core/stereo/shapes_artifact.h"
#include "tests/fuzz/entry.h"
#include "tests/fuzz/formats.h"

namespace vitrine {

// Every shape that is read answers rays and points without leaving its numbers.
void fuzz_shapes(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("shapes.json", text_of(bytes));
  refuses_or_reads([&] {
    for (const ShapeSet::Entry& entry : read_shapes_file(path).entries) {
      (void)bounds(entry.shape);
      (void)intersect(entry.shape, {{3, 0.1, 0.2}, {-1, 0.02, -0.05}});
      (void)nearest(entry.shape, {0.3, 0.2, 0.1});
      if (parameter_count(entry.shape) < 10000) (void)moved(entry.shape, std::vector<double>(parameter_count(entry.shape), 1e-3));
    }
  });
}

std::vector<std::string> shapes_corpus() {
  Rng rng(5, 1);
  ShapeSet all;
  for (const ShapeKind& kind : shape_kinds())
    all.entries.push_back({kind.sample(rng), ShapeRole::Mirror, 0.01, all.entries.empty() ? -1 : 0, {}});
  const nlohmann::ordered_json document{{"shapes", write_shapes(all, fuzz_folder())}};
  return {readable(document)};
}

}  // namespace vitrine
