// Tables of objects: a JSON document, and meshes beside it.
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/scene/objects/object_set.h"
#include "core/scene/shape/shape_file.h"
#include "tests/fuzz/entry.h"
#include "tests/fuzz/formats.h"

namespace vitrine {

// Every table that is read is consistent, and its shapes answer rays and points without leaving their numbers.
void fuzz_objects(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("objects.json", text_of(bytes));
  refuses_or_reads([&] {
    const ObjectSet set = read_objects_file(path);
    for (size_t i = 0; i < set.shapes.entries.size(); ++i) {
      const ShapeSet::Entry& entry = set.shapes.entries[i];
      if (set.of_shape(i) == nullptr) std::abort();
      (void)bounds(entry.shape);
      (void)intersect(entry.shape, {{3, 0.1, 0.2}, {-1, 0.02, -0.05}});
      (void)nearest(entry.shape, {0.3, 0.2, 0.1});
      if (parameter_count(entry.shape) < 10000) (void)moved(entry.shape, std::vector<double>(parameter_count(entry.shape), 1e-3));
    }
    (void)set.trusted().drawn_shapes();
  });
}

std::vector<std::string> objects_corpus() {
  Rng rng(5, 1);
  ObjectSet all;
  all.objects = {{.id = 3, .name = "kettle", .role = ObjectRole::Mirror, .evidence = {.views = 4, .inside = 0.9}}};
  for (const ShapeKind& kind : shape_kinds())
    all.shapes.entries.push_back({.shape = kind.sample(rng),
                                  .role = ShapeRole::Mirror,
                                  .tolerance = 0.01,
                                  .parent = all.shapes.entries.empty() ? -1 : 0,
                                  .clear = {},
                                  .object = 3});
  write_objects(fuzz_folder(), all);
  return {read_file(fuzz_folder() / "objects.json")};
}

}  // namespace vitrine
