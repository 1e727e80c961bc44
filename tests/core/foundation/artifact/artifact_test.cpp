#include <fcntl.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"

namespace vitrine {
namespace {

const std::string kKey(32, 'a');

Manifest example(const std::string& key = kKey) {
  Manifest m;
  m.stage = "mesh";
  m.key = key;
  m.terms = {{"stage", "mesh"}, {"version", "1"}, {"option.voxel", "0.004"}};
  m.metrics = {{"faces", 12}};
  m.warnings = {{"HOLE", "one hole"}};
  m.options = {{"voxel", "0.004", "default"}};
  m.summary = "12 faces";
  return m;
}

fs::path commit(ArtifactStore& store, const std::string& text, const std::string& key = kKey) {
  PendingArtifact pending(store, "mesh", key);
  write_file(pending.path() / "mesh/a.ply", text);
  write_file(pending.path() / "b ä.txt", "b");
  Manifest m = example(key);
  return pending.commit(m, "{}");
}

// Sets the time back.
void age(const fs::path& path) { fs::last_write_time(path, fs::last_write_time(path) - std::chrono::seconds(10)); }

TEST(Store, CommitsWholeArtifactsWithDigests) {
  TemporaryFolder folder;
  ArtifactStore store(folder.path());
  EXPECT_FALSE(store.find("mesh", kKey));
  const fs::path entry = commit(store, "mesh");
  const auto m = store.find("mesh", kKey);
  ASSERT_TRUE(m);
  ASSERT_EQ(m->outputs.size(), 2u);
  EXPECT_EQ(m->outputs[0].path, "b ä.txt");
  EXPECT_EQ(m->outputs[1].bytes, 4u);
  EXPECT_EQ(m->metrics.at("faces"), 12);
  EXPECT_EQ(m->warnings[0].code, "HOLE");
  EXPECT_EQ(m->options[0].origin, "default");
  EXPECT_EQ(m->summary, "12 faces");
  EXPECT_EQ(store.damage(entry), "");
}

TEST(Store, ContentDigestDependsOnBytesAlone) {
  TemporaryFolder one, two;
  ArtifactStore a(one.path()), b(two.path());
  commit(a, "same");
  commit(b, "same");
  const std::string first = a.find("mesh", kKey)->content_digest;
  EXPECT_EQ(first, b.find("mesh", kKey)->content_digest);
  commit(b, "else");  // replaces the entry of the same key
  EXPECT_NE(first, b.find("mesh", kKey)->content_digest);
  EXPECT_EQ(b.entries().size(), 1u);
}

TEST(Store, NoticesEveryKindOfDamage) {
  TemporaryFolder folder;
  ArtifactStore store(folder.path());
  const fs::path entry = commit(store, "mesh");
  std::ofstream(entry / "mesh/a.ply") << "MESH";
  EXPECT_EQ(store.damage(entry), "mesh/a.ply has other contents than when it was written");
  std::ofstream(entry / "mesh/a.ply") << "me";
  EXPECT_EQ(store.damage(entry), "mesh/a.ply has 2 bytes instead of 4");
  fs::remove(entry / "mesh/a.ply");
  EXPECT_EQ(store.damage(entry), "mesh/a.ply is missing");
  std::ofstream(entry / "mesh/a.ply") << "mesh";
  EXPECT_EQ(store.damage(entry), "");
  std::ofstream(entry / "extra") << "x";
  EXPECT_EQ(store.damage(entry), "it holds 3 files instead of 2");
  std::ofstream(entry / "manifest.json") << "{\"format\": 1";
  EXPECT_EQ(store.damage(entry), "a manifest cannot be read");
  EXPECT_THROW(store.find("mesh", kKey), Error);
}

TEST(Store, AbandonedFoldersVanish) {
  TemporaryFolder folder;
  ArtifactStore store(folder.path());
  { PendingArtifact pending(store, "mesh", kKey); }
  EXPECT_TRUE(store.entries().empty());
  const pid_t child = fork();
  if (child == 0) {  // dies without a destructor, as under kill -9
    PendingArtifact pending(store, "mesh", kKey);
    write_file(pending.path() / "half", "x");
    _exit(9);
  }
  waitpid(child, nullptr, 0);
  ASSERT_EQ(store.entries().size(), 1u);
  EXPECT_FALSE(store.entries()[0].committed);
  EXPECT_FALSE(store.find("mesh", kKey));
  PendingArtifact mine(store, "mesh", std::string(32, 'b'));
  EXPECT_EQ(store.sweep("mesh"), 1);
  EXPECT_TRUE(fs::exists(mine.path()));
}

// Process ids of another machine mean nothing here; the lock of the key does.
TEST(Store, FoldersWhoseOwnerHoldsTheLockOfTheirKeyStay) {
  TemporaryFolder folder;
  ArtifactStore store(folder.path());
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);  // an id without a process
  const fs::path pending = folder.path() / "mesh" / fmt::format("{}.tmp-{}", kKey, child);
  make_folders(pending);
  make_folders(store.scratch("mesh", kKey));
  const int lock = open((store.scratch("mesh", kKey) / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  ASSERT_EQ(flock(lock, LOCK_EX), 0);
  EXPECT_EQ(store.sweep("mesh"), 0);
  EXPECT_TRUE(fs::exists(pending));
  close(lock);
  EXPECT_EQ(store.sweep("mesh"), 1);
  EXPECT_FALSE(fs::exists(pending));
}

TEST(Key, DependsOnEveryTerm) {
  const KeyTerms terms = example().terms;
  const std::string key = key_of(terms);
  EXPECT_EQ(key.size(), 32u);
  for (const auto& [name, value] : terms) {
    KeyTerms other = terms;
    other[name] += "x";
    EXPECT_NE(key_of(other), key) << name;
  }
}

TEST(Key, ChangesAreToldInWords) {
  const KeyTerms a = {{"version", "1"}, {"option.voxel", "0.004"}, {"input.sfm", "aa"}, {"tool.colmap", "3.8"}};
  const KeyTerms b = {
      {"version", "2"}, {"option.voxel", "0.002"}, {"input.sfm", "bb"}, {"tool.colmap", "4.1"}, {"input.masks", "c"}};
  EXPECT_EQ(changed_terms(a, b),
            (std::vector<std::string>{"input masks added", "input sfm changed", "option voxel 0.004 -> 0.002",
                                      "colmap 3.8 -> 4.1", "version 1 -> 2"}));
  EXPECT_TRUE(changed_terms(a, a).empty());
}

// Files that changed a moment ago are not remembered: their time may not tell a second change.
void settle() { std::this_thread::sleep_for(std::chrono::milliseconds(150)); }

TEST(DigestCache, TouchingAFileKeepsItsDigest) {
  TemporaryFolder folder;
  const fs::path photos = folder.path() / "photos", file = folder.path() / "digests.txt";
  write_file(photos / "a.jpg", "picture");
  write_file(photos / ".DS_Store", "junk");
  settle();
  std::string first;
  {
    DigestCache cache(file);
    first = cache.digest_tree(photos);
  }
  ASSERT_TRUE(fs::exists(file));
  fs::last_write_time(photos / "a.jpg", fs::file_time_type::clock::now() - std::chrono::seconds(5));
  write_file(photos / ".DS_Store", "other junk");
  write_file(photos / "@eaDir/a.jpg", "a thumbnail of a network drive");
  EXPECT_EQ(DigestCache(file).digest_tree(photos), first);
  fs::rename(photos, folder.path() / "moved");
  EXPECT_EQ(DigestCache(file).digest_tree(folder.path() / "moved"), first);
  write_file(folder.path() / "moved/a.jpg", "Picture");
  EXPECT_NE(DigestCache(file).digest_tree(folder.path() / "moved"), first);
  fs::rename(folder.path() / "moved/a.jpg", folder.path() / "moved/b.jpg");
  EXPECT_THROW(DigestCache(file).digest(folder.path() / "moved/a.jpg"), Error);
}

TEST(DigestCache, DoesNotReadAnUnchangedFileAgain) {
  TemporaryFolder folder;
  const fs::path photo = folder.path() / "a.jpg", file = folder.path() / "digests.txt";
  write_file(photo, "picture");
  settle();
  const std::string digest = DigestCache(file).digest(photo), invented(32, '7');
  std::string known = read_file(file);
  ASSERT_NE(known.find(digest), std::string::npos);
  write_file(file, known.replace(known.find(digest), 32, invented));
  EXPECT_EQ(DigestCache(file).digest(photo), invented) << "answered from the file of digests";
}

TEST(DigestCache, SeesAnEditThatKeepsSizeAndTime) {
  TemporaryFolder folder;
  const fs::path photo = folder.path() / "a.jpg", file = folder.path() / "digests.txt";
  write_file(photo, "picture");
  age(photo);
  settle();
  const std::string first = DigestCache(file).digest(photo);
  const auto time = fs::last_write_time(photo);
  std::ofstream(photo) << "PICTURE";  // in place: the inode stays
  fs::last_write_time(photo, time);
  EXPECT_NE(DigestCache(file).digest(photo), first);
  std::ofstream(photo) << "picture";
  fs::last_write_time(photo, time);
  EXPECT_EQ(DigestCache(file).digest(photo), first) << "the old content has the old digest";
}

TEST(DigestCache, SeesWhatLiesBehindLinks) {
  TemporaryFolder folder;
  const fs::path photos = folder.path() / "photos", other = folder.path() / "other";
  write_file(photos / "a.jpg", "a");
  write_file(other / "b.jpg", "b");
  DigestCache cache({});
  const std::string alone = cache.digest_tree(photos);
  fs::create_directory_symlink(other, photos / "day2");
  fs::create_directory_symlink(photos, photos / "circle");
  fs::create_symlink(folder.path() / "nowhere", photos / "c.jpg");
  const std::string linked = cache.digest_tree(photos);
  EXPECT_NE(linked, alone);
  write_file(other / "b.jpg", "B");
  EXPECT_NE(cache.digest_tree(photos), linked);
}

}  // namespace
}  // namespace vitrine
