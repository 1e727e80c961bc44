// Lists of seeds and of arms as they are typed.
#include "tests/bench/optics/arms.h"

#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using Numbers = std::vector<int>;

TEST(SeedList, HoldsRangesAndNumbersInTheirOrderEachOnce) {
  EXPECT_EQ(seed_list("1-4", "--seeds"), (Numbers{1, 2, 3, 4}));
  EXPECT_EQ(seed_list("7,1-3,2,101-102", "--seeds"), (Numbers{7, 1, 2, 3, 101, 102}));
  EXPECT_EQ(seed_list("5", "--seeds"), Numbers{5});
}

TEST(SeedList, RefusesWhatIsNoNumberAndRangesThatEndBeforeTheyBegin) {
  for (const char* bad : {"", "1,", "a", "1-x", "3-1", "-2", "1.5", "1 2", "1-99999999"}) {
    const Error e = error_of([&] { seed_list(bad, "--training-seeds"); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << bad;
    EXPECT_NE(e.message().find("--training-seeds"), std::string::npos) << bad;
  }
}

TEST(ArmList, KnowsThreeNamesAndTakesOptions) {
  const auto arms = arm_list("diffuse,full,auto,soft:optimize.layers=full;optimize.loss.l1=0.5");
  ASSERT_EQ(arms.size(), 4u);
  EXPECT_EQ(arms[0].options.at("optimize.layers"), "diffuse");
  EXPECT_EQ(arms[1].options.at("optimize.layers"), "auto");
  EXPECT_EQ(arms[0].source("masks"), "truth");
  EXPECT_EQ(arms[0].source("poses"), "truth");
  EXPECT_EQ(arms[2].source("masks"), "none");
  EXPECT_EQ(arms[2].source("poses"), "truth");
  EXPECT_EQ(arms[3].name, "soft");
  EXPECT_EQ(arms[3].options.at("optimize.loss.l1"), "0.5");
}

TEST(ArmList, OptionsJoinThoseOfAKnownName) {
  const auto arms = arm_list("full:input.poses=none;input.masks=marks;optimize.layers=auto");
  EXPECT_EQ(arms[0].options.at("optimize.layers"), "auto");
  EXPECT_EQ(arms[0].source("poses"), "none");
  EXPECT_EQ(arms[0].source("masks"), "marks");
}

TEST(ArmList, CommasInBracketsAndQuotesBelongToAValue) {
  const auto arms = arm_list("a:normals.geometric.hull=[transparent, specular],b:masks.flat=\"x,y;z\"");
  ASSERT_EQ(arms.size(), 2u);
  EXPECT_EQ(arms[0].options.at("normals.geometric.hull"), "[transparent, specular]");
  EXPECT_EQ(arms[1].options.at("masks.flat"), "\"x,y;z\"");
}

TEST(ArmList, RefusesUnknownNamesNamesTwiceAndWhatIsNoOption) {
  EXPECT_NE(std::string(error_of([] { arm_list("ful"); }).what()).find("did you mean 'full'"), std::string::npos);
  for (const char* bad : {"", "full,full", "../x:a.b=1", "a:", "a:layers=full", "a:optimize.layers", "a:input.truth=none",
                          "a:input.masks=some", "a:input.poses=marks"})
    EXPECT_EQ(error_of([&] { arm_list(bad); }).kind(), ErrorKind::Usage) << bad;
}

}  // namespace
}  // namespace vitrine
