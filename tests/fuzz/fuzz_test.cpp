// A fixed number of damaged inputs per format, the same each time. A run that ends by a signal: vitrine-fuzz FORMAT with the seed
// and the number of runs below, and --keep FILE, leaves the input.
#include <gtest/gtest.h>

#include "tests/fuzz/mutate.h"

namespace vitrine {
namespace {

class Fuzz : public testing::TestWithParam<std::string_view> {};

TEST_P(Fuzz, EveryInputIsReadOrRefused) {
  const FuzzFormat& format = fuzz_format(GetParam());
  const uint64_t runs = format.name == "film"   ? 12  // three processes each
                        : format.name == "onnx" ? 40
                        : format.name == "exr" || format.name == "heif" || format.name.ends_with("photo") || format.name == "icc"
                            ? 100
                            : 250;
  EXPECT_GE(fuzz(format, {.runs = runs, .seed = 20}), runs);
}

std::vector<std::string_view> names() {
  std::vector<std::string_view> all;
  for (const FuzzFormat& f : fuzz_formats()) all.push_back(f.name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(Formats, Fuzz, testing::ValuesIn(names()), [](const auto& i) { return std::string(i.param); });

TEST(Mutation, IsTheSameForASeedAndANumber) {
  const FuzzFormat& format = fuzz_format("yaml");
  const auto corpus = format.corpus();
  EXPECT_EQ(mutated(format, corpus, 3, 17), mutated(format, corpus, 3, 17));
  EXPECT_NE(mutated(format, corpus, 3, 17), mutated(format, corpus, 3, 18));
  EXPECT_NE(mutated(format, corpus, 3, 17), mutated(format, corpus, 4, 17));
}

}  // namespace
}  // namespace vitrine
