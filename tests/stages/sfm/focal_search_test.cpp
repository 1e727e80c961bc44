// Focal lengths of single photos fall into groups only where a gap separates them clearly.
#include "stages/sfm/focal_search.h"

#include <gtest/gtest.h>

namespace vitrine {
namespace {

TEST(FocalGroups, TwoLensesAreTwoGroups) {
  const std::vector<double> focals{390, 760, 375, 0, 740, 380, 755, 384, 560, 748};
  const std::vector<FocalGroup> groups = focal_groups(focals);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].members, (std::vector<size_t>{0, 2, 5, 7})) << "the unknown one belongs to none";
  EXPECT_EQ(groups[1].members, (std::vector<size_t>{1, 4, 6, 8, 9})) << "an outlier belongs to the nearest";
  EXPECT_NEAR(groups[0].focal, 384, 6);
  EXPECT_NEAR(groups[1].focal, 750, 10);
}

TEST(FocalGroups, ThreeLensesAreThreeGroups) {
  const std::vector<double> focals{300, 305, 298, 600, 610, 605, 1500, 1480, 1510};
  EXPECT_EQ(focal_groups(focals).size(), 3u);
}

TEST(FocalGroups, SpreadAndOutliersOfOneLensAreNoGroups) {
  for (const std::vector<double>& focals :
       std::vector<std::vector<double>>{{},
                                        {0, 0, 0},
                                        {300, 302, 299, 301, 305, 298},
                                        {280, 290, 300, 310, 320, 330, 340, 350, 360, 370},       // spread without a gap
                                        {300, 302, 299, 301, 305, 600, 610},                      // two outliers
                                        {300, 301, 302, 330, 331, 332},                           // a gap of a tenth
                                        {200, 230, 265, 305, 600, 700, 800, 930, 1100, 1300}}) {  // two spreads
    EXPECT_TRUE(focal_groups(focals).empty()) << ::testing::PrintToString(focals);
  }
}

}  // namespace
}  // namespace vitrine
