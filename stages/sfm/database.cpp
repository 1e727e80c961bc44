#include "stages/sfm/database.h"

#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>

#include "core/foundation/base/error.h"
#include "stages/sfm/matcher.h"

namespace vitrine {

namespace {

constexpr const char* kTryAgain = "`vitrine doctor` says which colmap is used; then --from sfm --force";

constexpr uint64_t kPairBase = 2147483647;  // pair_id = kPairBase * smaller id + larger id

// VLFeat (the SIFT inside COLMAP) silently skips the descriptor of a keypoint in the last row of its octave: the descriptor is
// uninitialised memory and differs between runs. A row of the octave covers up to 2.5 sigma of the picture.
bool descriptor_is_undefined(std::span<const float> keypoint, double height) {
  double sigma = 1;
  if (keypoint.size() >= 6) sigma = std::sqrt(std::abs(double(keypoint[2]) * keypoint[5] - double(keypoint[3]) * keypoint[4]));
  if (keypoint.size() == 4) sigma = keypoint[2];
  return height - keypoint[1] < 3 * sigma + 1;
}

// A disk that is full, or a file system that lacks what SQLite needs, is no fault of COLMAP.
[[noreturn]] void throw_database_error(sqlite3* db, const fs::path& path, const char* what, const std::string& why) {
  const int code = sqlite3_errcode(db) & 0xff;
  const bool full = code == SQLITE_FULL, disk = full || code == SQLITE_IOERR || code == SQLITE_PROTOCOL;
  throw Error(
      disk ? ErrorKind::Resource : ErrorKind::Dependency, fmt::format("COLMAP's database cannot be {}", what),
      {.where = path.string(),
       .why = why,
       .hint = full   ? "free some disk space and run the same command again"
               : disk ? "free some disk space, or put the output folder (-o) on a local disk: network file systems may lack "
                        "what a database needs"
                      : "run again; if it stays, look at the COLMAP log",
       .code = full   ? "DISK_FULL"
               : disk ? "SFM_DATABASE_DISK"
                      : "SFM_DATABASE"});
}

class Statement {
 public:
  Statement(sqlite3* db, const fs::path& path, const std::string& sql) : db_(db), path_(path) {
    if (sqlite3_prepare_v2(db, sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK) fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  bool step() {
    const int rc = sqlite3_step(statement_);
    if (rc != SQLITE_ROW && rc != SQLITE_DONE) fail();
    return rc == SQLITE_ROW;
  }
  int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
  std::string text(int column) const {
    const unsigned char* t = sqlite3_column_text(statement_, column);
    return t == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(t));
  }
  std::pair<const void*, size_t> blob(int column) const {
    return {sqlite3_column_blob(statement_, column), static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
  }
  void bind(int at, const std::string& text) { sqlite3_bind_text(statement_, at, text.c_str(), -1, SQLITE_TRANSIENT); }

 private:
  [[noreturn]] void fail() const { throw_database_error(db_, path_, "read", sqlite3_errmsg(db_)); }
  sqlite3* db_;
  const fs::path& path_;
  sqlite3_stmt* statement_ = nullptr;
};

}  // namespace

ColmapDatabase::ColmapDatabase(const fs::path& path) : path_(path) {
  if (!fs::is_regular_file(path))
    throw Error(ErrorKind::Dependency, "COLMAP left no database",
                {.where = path.string(), .hint = kTryAgain, .code = "SFM_DATABASE"});
  if (sqlite3_open_v2(path.c_str(), &handle_, SQLITE_OPEN_READWRITE, nullptr) != SQLITE_OK) {
    const std::string why = handle_ == nullptr ? "out of memory" : sqlite3_errmsg(handle_);
    sqlite3_close(handle_);
    throw Error(ErrorKind::Dependency, "COLMAP's database cannot be opened",
                {.where = path.string(), .why = why, .hint = kTryAgain, .code = "SFM_DATABASE"});
  }
  try {
    for (const char* table : {"cameras", "images", "keypoints", "descriptors", "matches", "two_view_geometries"})
      if (!has_table(table))
        throw Error(
            ErrorKind::Dependency, "COLMAP's database is incomplete",
            {.where = path.string(), .why = fmt::format("no table '{}'", table), .hint = kTryAgain, .code = "SFM_DATABASE"});
  } catch (...) {
    sqlite3_close(handle_);
    throw;
  }
}

ColmapDatabase::~ColmapDatabase() { sqlite3_close(handle_); }

void ColmapDatabase::execute(const std::string& sql) const {
  char* message = nullptr;
  if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, &message) == SQLITE_OK) return;
  const std::string why = message == nullptr ? sqlite3_errmsg(handle_) : message;
  sqlite3_free(message);
  throw_database_error(handle_, path_, "written", why);
}

bool ColmapDatabase::has_table(const std::string& name) const {
  Statement s(handle_, path_, "SELECT 1 FROM sqlite_master WHERE type='table' AND name=?");
  s.bind(1, name);
  return s.step();
}

bool ColmapDatabase::has_frames() const { return has_table("frames"); }

void ColmapDatabase::renumber_by_name() {
  std::vector<int64_t> ids;
  {
    Statement s(handle_, path_, "SELECT image_id FROM images ORDER BY name");
    while (s.step()) ids.push_back(s.integer(0));
  }
  std::string sql = "BEGIN;";
  // Two passes, so that no id is used twice at any time.
  constexpr int64_t kAway = 1000000000;
  for (const bool away : {true, false}) {
    for (size_t i = 0; i < ids.size(); ++i) {
      const int64_t from = away ? ids[i] : kAway + ids[i], to = away ? kAway + ids[i] : static_cast<int64_t>(i) + 1;
      for (const char* table : {"images", "keypoints", "descriptors"})
        sql += fmt::format("UPDATE {} SET image_id={} WHERE image_id={};", table, to, from);
    }
  }
  execute(sql + "COMMIT;");
}

std::vector<PhotoFeatures> ColmapDatabase::features() const {
  std::vector<PhotoFeatures> out;
  Statement s(handle_, path_,
              "SELECT i.image_id, i.name, k.rows, k.cols, k.data, d.rows, d.cols, d.data, i.camera_id, c.height FROM images i "
              "LEFT JOIN keypoints k ON k.image_id = i.image_id LEFT JOIN descriptors d ON d.image_id = i.image_id LEFT JOIN "
              "cameras c ON c.camera_id = i.camera_id ORDER BY i.name");
  while (s.step()) {
    PhotoFeatures f;
    f.image_id = static_cast<uint32_t>(s.integer(0));
    f.camera_id = static_cast<uint32_t>(s.integer(8));
    f.name = s.text(1);
    f.count = static_cast<size_t>(s.integer(2));
    const size_t columns = static_cast<size_t>(s.integer(3));
    const auto [keypoints, keypoint_bytes] = s.blob(4);
    const auto [descriptors, descriptor_bytes] = s.blob(7);
    const bool sound =
        f.count == 0 ||
        (columns >= 2 && keypoint_bytes == f.count * columns * sizeof(float) && static_cast<size_t>(s.integer(5)) == f.count &&
         s.integer(6) == int64_t(kDescriptorBytes) && descriptor_bytes == f.count * kDescriptorBytes);
    if (!sound)
      throw Error(ErrorKind::Dependency, "COLMAP's features have an unexpected layout",
                  {.where = path_.string(),
                   .why = fmt::format("{}: {} keypoints of {} columns in {} bytes, {} bytes of descriptors", f.name, f.count,
                                      columns, keypoint_bytes, descriptor_bytes),
                   .hint = kTryAgain,
                   .code = "SFM_DATABASE"});
    if (f.count > 0) {
      std::vector<float> rows(f.count * columns);
      std::memcpy(rows.data(), keypoints, keypoint_bytes);
      f.xy.resize(f.count * 2);
      for (size_t i = 0; i < f.count; ++i) f.xy[2 * i] = rows[i * columns], f.xy[2 * i + 1] = rows[i * columns + 1];
      f.descriptors.resize(descriptor_bytes);
      std::memcpy(f.descriptors.data(), descriptors, descriptor_bytes);
      const double height = double(s.integer(9));
      for (size_t i = 0; i < f.count; ++i)
        if (descriptor_is_undefined(std::span(rows).subspan(i * columns, columns), height))
          std::fill_n(f.descriptors.begin() + long(i * kDescriptorBytes), kDescriptorBytes, uint8_t{0});
    }
    out.push_back(std::move(f));
  }
  return out;
}

std::vector<VerifiedPair> ColmapDatabase::verified_pairs() const {
  std::vector<VerifiedPair> out;
  const auto column = [&](const char* name) {
    Statement s(handle_, path_, "SELECT 1 FROM pragma_table_info('two_view_geometries') WHERE name=?");
    s.bind(1, name);
    return s.step() ? std::string(name) : std::string("NULL");
  };
  Statement s(handle_, path_,
              fmt::format("SELECT pair_id, rows, {}, {} FROM two_view_geometries WHERE rows > 0 ORDER BY pair_id",
                          column("config"), column("H")));
  while (s.step()) {
    const uint64_t pair = static_cast<uint64_t>(s.integer(0));
    VerifiedPair& v = out.emplace_back();
    v.image_a = static_cast<uint32_t>(pair / kPairBase), v.image_b = static_cast<uint32_t>(pair % kPairBase);
    v.inliers = static_cast<size_t>(s.integer(1));
    v.config = static_cast<int>(s.integer(2));
    const auto [h, bytes] = s.blob(3);
    if (bytes != 9 * sizeof(double)) continue;
    v.homography.resize(9);
    std::memcpy(v.homography.data(), h, bytes);
  }
  return out;
}

std::vector<PairMatches> ColmapDatabase::matches_of(const char* table) const {
  std::vector<PairMatches> out;
  Statement s(handle_, path_, fmt::format("SELECT pair_id, rows, data FROM {} WHERE rows > 0 ORDER BY pair_id", table));
  while (s.step()) {
    const uint64_t pair = static_cast<uint64_t>(s.integer(0));
    const size_t rows = static_cast<size_t>(s.integer(1));
    const auto [data, bytes] = s.blob(2);
    if (bytes != rows * 2 * sizeof(uint32_t)) continue;
    PairMatches& m = out.emplace_back();
    m.image_a = static_cast<uint32_t>(pair / kPairBase), m.image_b = static_cast<uint32_t>(pair % kPairBase);
    m.features.resize(2 * rows);
    std::memcpy(m.features.data(), data, bytes);
  }
  return out;
}

std::vector<PairMatches> ColmapDatabase::descriptor_matches() const { return matches_of("matches"); }

std::vector<PairMatches> ColmapDatabase::inlier_matches() const { return matches_of("two_view_geometries"); }

size_t ColmapDatabase::examined_pairs() const {
  Statement s(handle_, path_, "SELECT COUNT(*) FROM two_view_geometries");
  return s.step() ? static_cast<size_t>(s.integer(0)) : 0;
}

void ColmapDatabase::drop_descriptors() { execute("DELETE FROM descriptors; VACUUM;"); }

void ColmapDatabase::drop_geometries() { execute("DELETE FROM matches; DELETE FROM two_view_geometries;"); }

void ColmapDatabase::replace_cameras(std::span<const ColmapCamera> cameras, const std::vector<bool>& known,
                                     std::span<const std::pair<uint32_t, size_t>> camera_of) {
  std::string sql = "BEGIN; DELETE FROM cameras;";
  for (size_t c = 0; c < cameras.size(); ++c) {
    const ColmapCamera& camera = cameras[c];
    std::string params;
    for (const std::byte b : std::as_bytes(std::span(camera.params))) params += fmt::format("{:02X}", uint8_t(b));
    sql += fmt::format(
        "INSERT INTO cameras(camera_id, model, width, height, params, prior_focal_length) VALUES({},{},{},{},X'{}',{});", c + 1,
        camera.model_id, camera.width, camera.height, params, int(known[c]));
  }
  for (const auto& [image, camera] : camera_of)
    sql += fmt::format("UPDATE images SET camera_id={} WHERE image_id={};", camera + 1, image);
  execute(sql + "COMMIT;");
}

void ColmapDatabase::take_geometries(const fs::path& other) {
  {
    Statement s(handle_, path_, "ATTACH DATABASE ? AS part");
    s.bind(1, other.string());
    s.step();
  }
  execute(
      "BEGIN; INSERT INTO matches SELECT * FROM part.matches; "
      "INSERT INTO two_view_geometries SELECT * FROM part.two_view_geometries; COMMIT; DETACH DATABASE part;");
}

}  // namespace vitrine
