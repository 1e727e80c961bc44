// The database code on files with COLMAP's own schema.
#include "stages/sfm/database.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include "core/foundation/base/error.h"
#include "stages/sfm/matcher.h"

namespace vitrine {
namespace {

void execute(const fs::path& path, const std::string& sql) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK) << (message ? message : "");
  sqlite3_free(message);
  sqlite3_close(db);
}

const char* kSchema =
    "CREATE TABLE cameras(camera_id INTEGER PRIMARY KEY, model INTEGER, width INTEGER, height INTEGER, params BLOB, "
    "prior_focal_length INTEGER);"
    "CREATE TABLE images(image_id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, camera_id INTEGER NOT NULL);"
    "CREATE TABLE keypoints(image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB);"
    "CREATE TABLE descriptors(image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB);"
    "CREATE TABLE matches(pair_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB);"
    "CREATE TABLE two_view_geometries(pair_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB, config INTEGER);";

// One keypoint at (0.5, 1) with six columns, and one descriptor whose bytes are all `tag`.
std::string photo(int id, const std::string& name, int tag, const std::string& y = "0000803F") {
  std::string descriptor, floats = "0000003F" + y;
  for (size_t i = 0; i < kDescriptorBytes; ++i) descriptor += fmt::format("{:02X}", tag);
  for (int i = 0; i < 4; ++i) floats += "00000000";
  return fmt::format(
      "INSERT INTO images VALUES({0},'{1}',1); INSERT INTO keypoints VALUES({0},1,6,X'{2}'); INSERT INTO descriptors "
      "VALUES({0},1,128,X'{3}');",
      id, name, floats, descriptor);
}

TEST(ColmapDatabase, CamerasAreReplaced) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "db";
  execute(path, std::string(kSchema) + "INSERT INTO cameras VALUES(7,2,150,100,NULL,1);" + photo(1, "a", 10) + photo(2, "b", 20));
  ColmapDatabase db(path);
  const std::vector<ColmapCamera> cameras{{.model_id = 0, .width = 150, .height = 100, .params = {120, 75, 50}},
                                          {.model_id = 2, .width = 150, .height = 100, .params = {240, 75, 50, 0.5}}};
  const std::vector<std::pair<uint32_t, size_t>> camera_of{{1, 1}, {2, 0}};
  db.replace_cameras(cameras, {true, false}, camera_of);
  const std::vector<PhotoFeatures> f = db.features();
  EXPECT_EQ(f[0].camera_id, 2u);
  EXPECT_EQ(f[1].camera_id, 1u);
  sqlite3* raw = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &raw), SQLITE_OK);
  std::string rows;
  const auto add = [](void* to, int n, char** values, char**) {
    for (int i = 0; i < n; ++i) *static_cast<std::string*>(to) += std::string(values[i]) + " ";
    return 0;
  };
  sqlite3_exec(raw, "SELECT camera_id, model, width, height, hex(params), prior_focal_length FROM cameras ORDER BY camera_id",
               add, &rows, nullptr);
  sqlite3_close(raw);
  EXPECT_EQ(rows,
            "1 0 150 100 0000000000005E400000000000C052400000000000004940 1 "
            "2 2 150 100 0000000000006E400000000000C052400000000000004940000000000000E03F 0 ");
}

TEST(ColmapDatabase, PutsIdsInTheOrderOfNames) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "db";
  execute(path, std::string(kSchema) + "INSERT INTO cameras VALUES(1,2,150,100,NULL,0);" + photo(1, "c", 30) + photo(2, "a", 10) +
                    photo(3, "b", 20) + "INSERT INTO images VALUES(4,'d',1);");
  ColmapDatabase db(path);
  EXPECT_FALSE(db.has_frames());
  db.renumber_by_name();
  const std::vector<PhotoFeatures> f = db.features();
  ASSERT_EQ(f.size(), 4u);
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(f[i].image_id, i + 1);
    EXPECT_EQ(f[i].name, std::string(1, char('a' + i)));
    EXPECT_EQ(f[i].descriptors, std::vector<uint8_t>(kDescriptorBytes, uint8_t(10 * (i + 1))));
    EXPECT_EQ(f[i].xy, (std::vector<float>{0.5f, 1.f}));
  }
  EXPECT_EQ(f[3].count, 0u);  // an unreadable picture has no features
}

TEST(ColmapDatabase, BlanksDescriptorsThatTheExtractorLeftUndefined) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "db";
  // sigma 0 here: the last pixel row of 100. 99.5 = 42C70000, 98.5 = 42C50000 (bytes reversed).
  execute(path, std::string(kSchema) + "INSERT INTO cameras VALUES(1,2,150,100,NULL,0);" + photo(1, "a", 9, "0000C742") +
                    photo(2, "b", 9, "0000C542"));
  const std::vector<PhotoFeatures> f = ColmapDatabase(path).features();
  EXPECT_EQ(f[0].xy[1], 99.5f);
  EXPECT_EQ(f[0].descriptors, std::vector<uint8_t>(kDescriptorBytes, 0));
  EXPECT_EQ(f[1].xy[1], 98.5f);
  EXPECT_EQ(f[1].descriptors, std::vector<uint8_t>(kDescriptorBytes, 9));
}

TEST(ColmapDatabase, TakesGeometriesOfAnotherFile) {
  const TemporaryFolder folder;
  execute(folder.path() / "a", std::string(kSchema) + "INSERT INTO two_view_geometries VALUES(2147483649,20,2,NULL,2);");
  execute(folder.path() / "it's b",
          std::string(kSchema) + "INSERT INTO two_view_geometries VALUES(4294967297,7,2,NULL,2),(4294967298,0,0,NULL,1);");
  ColmapDatabase db(folder.path() / "a");
  db.take_geometries(folder.path() / "it's b");
  const std::vector<VerifiedPair> pairs = db.verified_pairs();
  ASSERT_EQ(pairs.size(), 2u);  // pairs without inliers are not verified
  EXPECT_EQ(pairs[0].image_a, 1u);
  EXPECT_EQ(pairs[0].image_b, 2u);
  EXPECT_EQ(pairs[0].inliers, 20u);
  EXPECT_EQ(pairs[1].image_a, 2u);
  EXPECT_EQ(pairs[1].image_b, 3u);
}

TEST(ColmapDatabase, RefusesWhatIsNone) {
  const TemporaryFolder folder;
  EXPECT_THROW(ColmapDatabase(folder.path() / "missing"), Error);
  write_file(folder.path() / "text", std::string(5000, 'x'));
  EXPECT_THROW(ColmapDatabase(folder.path() / "text"), Error);
  execute(folder.path() / "other", "CREATE TABLE t(x INTEGER);");
  EXPECT_THROW(ColmapDatabase(folder.path() / "other"), Error);
  execute(folder.path() / "bad", std::string(kSchema) + photo(1, "a", 1) + "UPDATE descriptors SET cols=64;");
  EXPECT_THROW(ColmapDatabase(folder.path() / "bad").features(), Error);
}

}  // namespace
}  // namespace vitrine
