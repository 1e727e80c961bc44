// Lengths and scale bars as users write them.
#include "core/foundation/config/chart.h"

#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace vitrine {
namespace {

TEST(LengthText, ReadsUnitsAndRefusesTheRest) {
  for (const auto& [text, metres] : {std::pair{"0.24m", 0.24}, {"24cm", 0.24}, {"240 mm", 0.24}, {"1.5", 1.5}, {"1e-3m", 1e-3}}) {
    const auto length = parse_length(text);
    ASSERT_TRUE(length) << text;
    EXPECT_DOUBLE_EQ(length->metres, metres);
    EXPECT_EQ(length->has_unit, std::string_view(text) != "1.5");
  }
  for (const char* bad : {"", "cm", "0cm", "-1m", "5 km", "5cm2", "inf m", "nan", "1e400m", "5,3cm", " 5cm"})
    EXPECT_FALSE(parse_length(bad)) << bad;
}

TEST(ScaleBarText, ReadsMarksAndLength) {
  const ScaleBar bar = parse_scale_bar("IMG_8835.jpg:1,2.5,3,4   IMG_8837.jpg:10,20,30,40.25 = 5cm");
  EXPECT_DOUBLE_EQ(bar.length_m, 0.05);
  ASSERT_EQ(bar.marks.size(), 2u);
  EXPECT_EQ(bar.marks[0].photo, "IMG_8835.jpg");
  EXPECT_EQ(bar.marks[0].x1, 1);
  EXPECT_EQ(bar.marks[0].y1, 2.5);
  EXPECT_EQ(bar.marks[0].x2, 3);
  EXPECT_EQ(bar.marks[0].y2, 4);
  EXPECT_EQ(bar.marks[1].photo, "IMG_8837.jpg");
  EXPECT_EQ(bar.marks[1].y2, 40.25);
}

TEST(ScaleBarText, NamesMayHoldSpacesColonsAndEqualsSigns) {
  const ScaleBar bar = parse_scale_bar(" left/ä b.jpg:1,2,3,4 x=1, y:2.png:5,6,7,8\tc:1,1,2,2=80 mm ");
  ASSERT_EQ(bar.marks.size(), 3u);
  EXPECT_EQ(bar.marks[0].photo, "left/ä b.jpg");
  EXPECT_EQ(bar.marks[1].photo, "x=1, y:2.png");
  EXPECT_EQ(bar.marks[2].photo, "c");
  EXPECT_DOUBLE_EQ(bar.length_m, 0.08);
}

TEST(ScaleBarText, SaysWhatIsWrong) {
  const auto why = [](const std::string& text) {
    const Error e = error_of([&] { parse_scale_bar(text); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << text;
    EXPECT_EQ(e.detail().code, "SCALE_BAR");
    EXPECT_EQ(e.detail().where, text);
    return e.detail().why;
  };
  EXPECT_EQ(why("a:1,2,3,4 b:1,2,3,4"), "it does not end with the length of the bar, as in \"= 5cm\"");
  EXPECT_EQ(why("a:1,2,3,4 b:1,2,3,4 = 5"), "its length must be a number above zero with the unit m, cm or mm, got \"5\"");
  EXPECT_EQ(why("a:1,2,3,4 b:1,2,3,4 = 5 inch"),
            "its length must be a number above zero with the unit m, cm or mm, got \"5 inch\"");
  EXPECT_EQ(why("a:1,2,3,4 b:1,2,3,4 ="), "its length must be a number above zero with the unit m, cm or mm, got \"\"");
  EXPECT_EQ(why("a:1,2,3,4 = 5cm"), "its ends must be marked in two photos at least");
  EXPECT_EQ(why("= 5cm"), "its ends must be marked in two photos at least");
  EXPECT_EQ(why("a:1,2,3,4 a:5,6,7,8 = 5cm"), "'a' is marked twice");
  EXPECT_EQ(why("a:1,2,1,2 b:5,6,7,8 = 5cm"), "both ends are the same pixel of 'a'");
  for (const char* mark : {"b:1,2,3", "b:1,2,3,4,5", "b:1 2 3 4", "b:-1,2,3,4", "b:1,2,3,nan", "b:1,2,3,inf", ":1,2,3,4", "b",
                           "b:1:2:3:4", "b:1,2,3,1e999"})
    EXPECT_EQ(why(std::string("a:1,2,3,4 ") + mark + " = 5cm"),
              "\"" + std::string(mark) + "\" is not photo:x1,y1,x2,y2 with four numbers, none below zero");
}

TEST(ScalePointsText, ReadsPointsAndLength) {
  const ScalePoints points = parse_scale_points(" 0.5,-1e-1,2  0.5,0.2,2.4 25cm ");
  EXPECT_EQ(points.a, (std::array<double, 3>{0.5, -0.1, 2}));
  EXPECT_EQ(points.b, (std::array<double, 3>{0.5, 0.2, 2.4}));
  EXPECT_DOUBLE_EQ(points.length_m, 0.25);
  EXPECT_DOUBLE_EQ(points.scene_units(), 0.5);
}

TEST(ScalePointsText, RefusesTheRestWithTheReason) {
  const auto why = [](const std::string& text) {
    const Error e = error_of([&] { parse_scale_points(text); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << text;
    EXPECT_EQ(e.detail().code, "SCALE_POINTS") << text;
    return e.detail().why;
  };
  for (const char* bad :
       {"", "1,2 3,4,5 1m", "1,2,3,4 3,4,5 1m", "1,2,x 3,4,5 1m", "nan,2,3 3,4,5 1m", "1,inf,3 3,4,5 1m", "1,2,3"})
    EXPECT_NE(why(bad).find("is not x,y,z"), std::string::npos) << bad;
  for (const char* bad : {"1,2,3 3,4,5", "1,2,3 3,4,5 1", "1,2,3 3,4,5 0cm", "1,2,3 3,4,5 -1m", "1,2,3 3,4,5 1m 2m"})
    EXPECT_NE(why(bad).find("the length must be"), std::string::npos) << bad;
  for (const char* bad : {"1,2,3 1,2,3 1m", "1.7e308,2,3 -1.7e308,4,5 1m"})
    EXPECT_NE(why(bad).find("the points are equal"), std::string::npos) << bad << ": " << why(bad);
}

}  // namespace
}  // namespace vitrine
