// Which photo is meant by a name in somebody's file.
#include "core/intake/poses/pose_files.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

using Names = std::vector<std::string>;

// The names of the photos that are meant; "-": none, "?": ambiguous.
Names meant(const Names& photos, const Names& names, const std::vector<fs::path>& folders = {}) {
  const PhotoNameFinder finder(photos);
  Names out;
  for (const PhotoMatch& m : finder.match(names, folders))
    out.push_back(m.photo ? finder.name(*m.photo) : m.could_be.empty() ? "-" : "?");
  return out;
}

TEST(PhotoNames, ThePathAsWrittenComesFirst) {
  EXPECT_EQ(meant({"images/a.jpg", "images_2/a.jpg", "a.jpg"}, {"images/a.jpg", "images_2/a.jpg", "a.jpg", "./images/../a.jpg"}),
            (Names{"images/a.jpg", "images_2/a.jpg", "a.jpg", "a.jpg"}));
}

TEST(PhotoNames, TheLongestEndOfAPathDecides) {
  const Names photos{"front/0.jpg", "back/0.jpg", "back/1.jpg"};
  EXPECT_EQ(meant(photos, {"images/front/0.jpg", "/home/me/set/back/0.jpg", "../../x/back/1.jpg"}),
            (Names{"front/0.jpg", "back/0.jpg", "back/1.jpg"}));
  EXPECT_EQ(meant({"set/images/a.jpg", "set/images_4/a.jpg"}, {"images/a.jpg"}), Names{"set/images/a.jpg"});
}

TEST(PhotoNames, OfEquallyLongEndsTheFolderOfMostNamesDecides) {
  EXPECT_EQ(meant({"p/x.jpg", "p/a/x.jpg", "p/a/y.jpg", "q/x.jpg", "p/z.jpg"}, {"x.jpg", "a/x.jpg", "a/y.jpg", "z.jpg"}),
            (Names{"p/x.jpg", "p/a/x.jpg", "p/a/y.jpg", "p/z.jpg"}));
}

TEST(PhotoNames, ThatMayMeanSeveralPhotosDecideNothingAndNameThem) {
  const Names photos{"front/0.jpg", "back/0.jpg"};
  const PhotoNameFinder finder(photos);
  const PhotoMatch m = finder.match("0.jpg");
  EXPECT_FALSE(m.photo);
  EXPECT_EQ(listed(finder, m.could_be), "front/0.jpg or back/0.jpg");
}

TEST(PhotoNames, OfWindowsAreUnderstood) {
  const Names photos{"cam/a.jpg", "cam/train_0.jpg"};
  for (const char* name : {"cam\\a.jpg", "C:\\Users\\me\\cam\\a.jpg", ".\\cam\\a.jpg", "\\\\server\\share\\cam\\a.jpg"})
    EXPECT_EQ(meant(photos, {name}), Names{"cam/a.jpg"}) << name;
  // A backslash that JSON took for the beginning of a tab.
  EXPECT_EQ(meant(photos, {"cam\train_0.jpg"}), Names{"cam/train_0.jpg"});
  // A photo may have one in its name.
  EXPECT_EQ(meant({"a\\b.jpg", "b.jpg"}, {"a\\b.jpg"}), Names{"a\\b.jpg"});
}

TEST(PhotoNames, AsAddressesAreUnderstood) {
  EXPECT_EQ(meant({"a b.jpg"}, {"file:///home/me/a%20b.jpg"}), Names{"a b.jpg"});
  EXPECT_EQ(meant({"my set/a b.jpg", "c.jpg"}, {"my%20set/A%20B", "c.jpg"}), (Names{"my set/a b.jpg", "c.jpg"}));
  EXPECT_EQ(meant({"h\xc3\xa4user 1.jpg"}, {"images/h%C3%A4user%201.jpg"}), Names{"h\xc3\xa4user 1.jpg"});
  // A photo may have such a name, and a per cent sign need not mean anything.
  EXPECT_EQ(meant({"a%20b.jpg", "a b.jpg"}, {"a%20b.jpg", "a b.jpg"}), (Names{"a%20b.jpg", "a b.jpg"}));
  EXPECT_EQ(meant({"50%.jpg", "100%zz.jpg"}, {"50%.jpg", "100%zz.jpg"}), (Names{"50%.jpg", "100%zz.jpg"}));
  EXPECT_EQ(meant({"a b.jpg"}, {"%2F", "%", "a%2", "x%20b.jpg"}), (Names{"-", "-", "-", "-"}));
}

TEST(PhotoNames, MayLackOrChangeTheExtension) {
  EXPECT_EQ(meant({"r_0.png", "r_10.png"}, {"./train/r_0", "r_10.jpg"}), (Names{"r_0.png", "r_10.png"}));
  EXPECT_EQ(meant({"a.jpg"}, {"a.jpg.png"}), Names{"a.jpg"});
  EXPECT_EQ(meant({"v1.25.jpg", "v1.50.jpg"}, {"v1.25"}), Names{"v1.25.jpg"});
  EXPECT_EQ(meant({"a.jpg", "a.png"}, {"a.JPG"}), Names{"a.jpg"}) << "letter case before extension";
  EXPECT_EQ(meant({"a.jpg", "a.png"}, {"a.tif"}), Names{"?"});
}

TEST(PhotoNames, MayDifferInLetterCaseAndInHowAccentsAreComposed) {
  EXPECT_EQ(meant({"IMG_1.JPG"}, {"img_1.jpg"}), Names{"IMG_1.JPG"});
  EXPECT_EQ(meant({"caf\xc3\xa9/\xe3\x81\x8c.jpg"}, {"cafe\xcc\x81/\xe3\x81\x8b\xe3\x82\x99.jpg"}),
            Names{"caf\xc3\xa9/\xe3\x81\x8c.jpg"});
  EXPECT_EQ(meant({"a.jpg", "A.jpg"}, {"A.jpg", "a.jpg"}), (Names{"A.jpg", "a.jpg"})) << "two photos on Linux";
  EXPECT_EQ(meant({"images/a.jpg", "images_2/a.jpg"}, {"Images/a.jpg"}), Names{"images/a.jpg"});
  EXPECT_EQ(meant({"a/b.jpg", "b", "b.jpg"}, {"a/b"}), Names{"a/b.jpg"}) << "a longer end before the extension";
}

TEST(PhotoNames, OfAFolderThatIsThereAreNotLookedForInAnother) {
  // right/2.jpg is not left/2.jpg: other names of left/ are photos of left/.
  EXPECT_EQ(meant({"left/1.jpg", "right/2.jpg"}, {"left/1.jpg", "left/2.jpg"}), (Names{"left/1.jpg", "-"}));
}

TEST(PhotoNames, OfOnePhotoTheBetterOneCounts) {
  const Names photos{"right/1.jpg"};
  const PhotoNameFinder finder(photos);
  const auto matches = finder.match(Names{"images/left/1.jpg", "images/right/1.jpg"});
  EXPECT_FALSE(matches[0].photo);
  EXPECT_EQ(matches[0].better_name, 1u);
  EXPECT_EQ(matches[1].photo, 0u);
  // Equally good ones are the caller's to judge.
  EXPECT_EQ(meant({"1.jpg"}, {"cam1/1.jpg", "cam2/1.jpg"}), (Names{"1.jpg", "1.jpg"}));
}

TEST(PhotoNames, AreReadFromTheFolderOfTheirFileWhenNothingElseDecides) {
  const TemporaryFolder folder;
  for (const char* name : {"photos/front/0.jpg", "photos/back/0.jpg"}) {
    make_folders((folder.path() / name).parent_path());
    write_file(folder.path() / name, "x");
  }
  EXPECT_EQ(meant({"front/0.jpg", "back/0.jpg"}, {"0.jpg"}, {folder.path() / "photos/back"}), Names{"back/0.jpg"});
  EXPECT_EQ(meant({"front/0.jpg", "back/0.jpg"}, {"0.jpg"}, {folder.path() / "elsewhere"}), Names{"?"});
}

TEST(PhotoNames, ThatAreNoNamesMeanNothing) {
  EXPECT_EQ(meant({"a.jpg"}, {"", "/", "..", "b.jpg", "a.jpg/"}), (Names{"-", "-", "-", "-", "a.jpg"}));
  EXPECT_EQ(meant({}, {"a.jpg"}), Names{"-"});
}

Photo photo_at(const std::string& source, int width, int height) {
  Photo p;
  p.name = p.source = source;
  p.stem = fs::path(source).replace_extension().string();
  p.width = p.original_width = width, p.height = p.original_height = height;
  return p;
}

TEST(PhotoFinder, KnowsAPhotoByItsFileAndByTheNameThatIngestGaveIt) {
  std::vector<Photo> photos{photo_at("a.jpg", 4, 3), photo_at("a.png", 4, 3), photo_at("b.exr", 4, 3)};
  photos[1].name = "a_png.png", photos[2].name = "b.png";
  const PhotoFinder find(photos);
  EXPECT_EQ(find.match("a.jpg").photo, 0u);
  EXPECT_EQ(find.match("a.png").photo, 1u);
  EXPECT_EQ(find.match("a_png.png").photo, 1u);
  EXPECT_EQ(find.match("b.exr").photo, 2u);
  EXPECT_EQ(find.match("b.png").photo, 2u);
}

TEST(FirstVersions, AreThoseThatDataSetsScaleDown) {
  const std::vector<Photo> photos{photo_at("images/a.JPG", 641, 480),   photo_at("images_2/a.png", 320, 240),
                                  photo_at("images_4/a.jpg", 640, 480), photo_at("input/a.jpg", 650, 490),
                                  photo_at("images_2/b.jpg", 320, 240), photo_at("left_2/a.jpg", 1, 1)};
  EXPECT_EQ(first_versions(photos), (std::vector<size_t>{0, 0, 2, 0, 4, 5}));
}

}  // namespace
}  // namespace vitrine
