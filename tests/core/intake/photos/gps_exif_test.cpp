// GPS directories of photos: places, references, errors as stated, and directories that give no place.
#include <gtest/gtest.h>

#include "core/intake/photos/exif.h"
#include "core/intake/photos/photo_list.h"
#include "tests/support/error_of.h"
#include "tests/support/gps_exif.h"

namespace vitrine {
namespace {

using test::exif_with_gps;
using test::place_tags;
using test::rationals;
using test::Tag;

std::optional<GpsPosition> read(const std::vector<Tag>& tags, bool big_endian = false) {
  return parse_exif(exif_with_gps(tags, big_endian)).gps;
}

std::vector<Tag> with(std::vector<Tag> tags, const Tag& tag) {
  std::erase_if(tags, [&](const Tag& t) { return t.id == tag.id; });
  tags.push_back(tag);
  std::ranges::sort(tags, {}, &Tag::id);
  return tags;
}

std::vector<Tag> without(std::vector<Tag> tags, unsigned id) {
  std::erase_if(tags, [&](const Tag& t) { return t.id == id; });
  return tags;
}

TEST(GpsExif, GivesThePlaceOnAllFourQuartersInBothByteOrders) {
  for (const bool big : {false, true})
    for (const double latitude : {47.3769123456, -33.8567844})
      for (const double longitude : {8.5417, -151.2152967})
        for (const double altitude : {431.25, -12.5}) {
          const auto gps = read(place_tags(latitude, longitude, altitude, big), big);
          ASSERT_TRUE(gps);
          EXPECT_NEAR(gps->latitude, latitude, 1e-10);
          EXPECT_NEAR(gps->longitude, longitude, 1e-10);
          EXPECT_DOUBLE_EQ(gps->altitude.value(), altitude);
          EXPECT_EQ(gps->datum, "");
          EXPECT_FALSE(gps->error_m);
        }
}

TEST(GpsExif, AltitudeIsUnknownWithoutAMeasuredOne) {
  EXPECT_FALSE(read(place_tags(47, 8, std::nullopt))->altitude);
  EXPECT_FALSE(read(place_tags(47, 8, 0))->altitude) << "receivers without a height write zero";
  EXPECT_FALSE(read(with(place_tags(47, 8, 10), {0x0006, 'r', 7, 0}))->altitude);
  EXPECT_FALSE(read(with(place_tags(47, 8, 10), {0x0006, 'r', 99999, 1}))->altitude) << "above all aircraft";
  EXPECT_DOUBLE_EQ(read(without(place_tags(47, 8, 10), 0x0005))->altitude.value(), 10) << "no reference: above sea level";
}

TEST(GpsExif, ErrorIsThatOfTheReceiverOrOfTheDilution) {
  EXPECT_DOUBLE_EQ(read(with(place_tags(47, 8, 10), {0x001f, 'r', 48, 10}))->error_m.value(), 4.8);
  EXPECT_DOUBLE_EQ(read(with(place_tags(47, 8, 10), {0x000b, 'r', 2, 1}))->error_m.value(), 5);
  EXPECT_DOUBLE_EQ(read(with(with(place_tags(47, 8, 10), {0x000b, 'r', 2, 1}), {0x001f, 'r', 3, 1}))->error_m.value(), 3);
  EXPECT_FALSE(read(with(place_tags(47, 8, 10), {0x001f, 'r', 0, 0}))->error_m);
}

TEST(GpsExif, NamesAnotherDatum) {
  for (const char* same : {"WGS-84", "WGS84", "wgs 84", "JGD2011", "ETRS89"})
    EXPECT_EQ(read(with(place_tags(47, 8, 10), {0x0012, 'a', 0, 1, same}))->datum, "") << same;
  EXPECT_EQ(read(with(place_tags(35, 139, 10), {0x0012, 'a', 0, 1, "TOKYO"}))->datum, "TOKYO");
}

TEST(GpsExif, SecondsMayBeUnknownOrPartOfTheMinutes) {
  const auto at = [](const std::vector<std::pair<unsigned, unsigned>>& latitude) {
    return read(with(place_tags(47, 8, 10), {0x0002, 'R', 0, 1, rationals(latitude)}));
  };
  EXPECT_DOUBLE_EQ(at({{47, 1}, {3012, 100}, {0, 1}})->latitude, 47 + 30.12 / 60);
  EXPECT_DOUBLE_EQ(at({{47, 1}, {3012, 100}, {0, 0}})->latitude, 47 + 30.12 / 60);
  EXPECT_DOUBLE_EQ(at({{475, 10}})->latitude, 47.5);
}

TEST(GpsExif, MalformedDirectoriesGiveNoPlace) {
  const std::vector<Tag> good = place_tags(47, 8, 10);
  ASSERT_TRUE(read(good));
  const std::pair<const char*, std::vector<Tag>> bad[] = {
      {"no latitude", without(good, 0x0002)},
      {"no longitude", without(good, 0x0004)},
      {"no reference", without(good, 0x0001)},
      {"an unknown reference", with(good, {0x0003, 'a', 0, 1, "X"})},
      {"degrees of 0/0", with(good, {0x0002, 'R', 0, 1, rationals({{0, 0}, {0, 0}, {0, 0}})})},
      {"minutes of 5/0", with(good, {0x0002, 'R', 0, 1, rationals({{47, 1}, {5, 0}, {0, 1}})})},
      {"61 minutes", with(good, {0x0002, 'R', 0, 1, rationals({{47, 1}, {61, 1}, {0, 1}})})},
      {"latitude 91", with(good, {0x0002, 'R', 0, 1, rationals({{91, 1}, {0, 1}, {0, 1}})})},
      {"longitude 181", with(good, {0x0004, 'R', 0, 1, rationals({{181, 1}, {0, 1}, {0, 1}})})},
      {"the largest numbers", with(good, {0x0002, 'R', 0, 1, rationals({{~0u, 1}, {~0u, 1}, {~0u, 1}})})},
      {"four parts", with(good, {0x0002, 'R', 0, 1, rationals({{47, 1}, {0, 1}, {0, 1}, {0, 1}})})},
      {"text", with(good, {0x0002, 'a', 0, 1, "47.5"})},
      {"zero and zero", place_tags(0, 0, 10)},
      {"an empty directory", {}},
  };
  for (const auto& [what, tags] : bad) EXPECT_FALSE(read(tags)) << what;
  const std::string block = exif_with_gps(good);
  for (size_t n = 0; n < block.size(); ++n) parse_exif(block.substr(0, n));  // ends, whatever is cut off
}

TEST(GpsExif, ThePhotoListHasItOnlyWhereItIsKnown) {
  TemporaryFolder folder;
  std::vector<Photo> photos(2);
  for (size_t i = 0; i < 2; ++i) {
    photos[i].name = photos[i].source = i == 0 ? "a.jpg" : "b.jpg";
    photos[i].stem = i == 0 ? "a" : "b";
    photos[i].width = photos[i].height = photos[i].original_width = photos[i].original_height = 10;
  }
  write_photo_list(folder.path(), photos);
  EXPECT_EQ(read_file(folder.path() / "ingest/photos.json").find("gps"), std::string::npos);
  photos[0].gps = GpsPosition{-47.1234567890123, 8.5, -3.25, "TOKYO", 4.5};
  photos[1].gps = GpsPosition{1e-9, -180, std::nullopt, "", std::nullopt};
  write_photo_list(folder.path(), photos);
  EXPECT_EQ(read_photo_list(folder.path()), photos);
  const std::string good = read_file(folder.path() / "ingest/photos.json");
  for (const auto& [from, to] :
       {std::pair("\"longitude\": 8.5", "\"longitude\": 181"), std::pair("\"error_m\": 4.5", "\"error_m\": 0"),
        std::pair("\"altitude\": -3.25", "\"altitude\": \"high\"")}) {
    std::string bad = good;
    const size_t at = bad.find(from);
    ASSERT_NE(at, std::string::npos) << from << good;
    write_file(folder.path() / "ingest/photos.json", bad.replace(at, std::string(from).size(), to));
    EXPECT_EQ(error_of([&] { read_photo_list(folder.path()); }).kind(), ErrorKind::Input) << to;
  }
}

}  // namespace
}  // namespace vitrine
