#include "core/scene/image/contact_sheet.h"

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

TEST(BitmapFont, DrawsInsideThePictureOnlyAndOneGlyphPerCharacter) {
  Image8 image(20, 9, 3);
  draw_text(image, 1, 1, "1", 1, 200);
  EXPECT_EQ(image.at(3, 1), 200);  // the stem of the one
  EXPECT_EQ(image.at(1, 1), 0);
  draw_text(image, 15, 5, "WW", 3);  // runs out of the picture on both sides
  draw_text(image, -4, -4, "W", 2);
  EXPECT_EQ(text_width("gr\xc3\xbcn", 2), 4 * 6 * 2);
}

TEST(ContactSheet, PutsFivePicturesInARowPerView) {
  const Image8 red(40, 30, 3, 90);
  const auto sheet_of = [&](int first, int second) {
    ContactSheet sheet(5);
    for (const int count : {first, second}) {
      sheet.start_row("A  20.00 DB");
      for (int i = 0; i < count; ++i) sheet.add("PHOTO", red);
    }
    return sheet.picture();
  };
  Image8 sheet = sheet_of(5, 5);
  constexpr int kBar = 26;
  EXPECT_EQ(sheet.width(), 5 * 44 + 4);
  EXPECT_EQ(sheet.height(), 2 * (2 * kBar + 34));
  EXPECT_EQ(sheet.at(4 + 4 * 44 + 20, 2 * kBar + 15), 90);  // middle of the last cell of the first row
  sheet = sheet_of(6, 5);                                   // the sixth stands below the first
  EXPECT_EQ(sheet.width(), 5 * 44 + 4);
  EXPECT_EQ(sheet.height(), 5 * kBar + 3 * 34);
  EXPECT_EQ(sheet.at(4 + 20, 3 * kBar + 34 + 15), 90);
  EXPECT_EQ(sheet.at(4 + 44 + 20, 3 * kBar + 34 + 15), 24);  // nothing beside it
}

TEST(ContactSheet, ShrinksLargePicturesAndWritesNoEmptyFile) {
  const TemporaryFolder folder;
  ContactSheet sheet(4, 100);
  sheet.start_row("");
  sheet.write(folder.path() / "sheet.png");
  EXPECT_FALSE(fs::exists(folder.path() / "sheet.png"));
  sheet.add("", Image8(200, 100, 1, 50));  // grey
  sheet.add("", Image8(60, 90, 3, 70));
  sheet.write(folder.path() / "sheet.png");
  EXPECT_TRUE(fs::exists(folder.path() / "sheet.png"));
  const Image8 picture = sheet.picture();
  EXPECT_EQ(picture.width(), 4 + 2 * 104);
  EXPECT_EQ(picture.height(), 26 + 90 + 4) << "no line for an empty label";
  EXPECT_EQ(picture.at(4 + 99, 26 + 49, 2), 50);
  EXPECT_EQ(picture.at(4 + 99, 26 + 50), 24);
  EXPECT_EQ(picture.at(108 + 59, 26 + 89), 70);
}

}  // namespace
}  // namespace vitrine
