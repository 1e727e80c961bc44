// Output folders of the version before: results of renamed stages under their new names.
#include "core/artifact/renamed_stage.h"

#include <gtest/gtest.h>

#include "core/artifact/current.h"
#include "core/artifact/publish.h"
#include "core/artifact/store.h"
#include "core/base/file.h"

namespace vitrine {
namespace {

class RenamedStages : public testing::Test {
 protected:
  // As a run leaves it: an artifact with one file, linked into the folder, and current.
  Manifest put(const std::string& stage, const std::string& file, const std::string& role = {}) {
    ArtifactStore store(store_of(project()));
    Manifest m;
    m.stage = stage;
    m.version = 3;
    m.terms = {{"stage", stage}, {"version", "3"}, {"input.relight", "d"}, {"option.a", role}};
    m.key = key_of(m.terms);
    PendingArtifact pending(store, stage, m.key);
    write_file(pending.path() / file, "of " + stage + role);
    const fs::path entry = pending.commit(m, "{\"seconds\": 5}\n");
    publish(entry, m, project());
    set_current_key(project(), role.empty() ? stage : role, m.key);
    return m;
  }
  fs::path project() const { return folder.path(); }
  TemporaryFolder folder;
};

TEST_F(RenamedStages, ResultsHaveTheKeyAndTheFoldersOfTheNewName) {
  const Manifest stage = put("relight", "relight/sub/a.txt");
  const Manifest tool = put("relit", "relit/sky/b.txt"), edited = put("relit", "relit/sun/c.txt", "relit-edited");
  put("mesh", "mesh/m.txt");
  ASSERT_TRUE(has_results_of_renamed_stages(project()));
  EXPECT_EQ(adopt_results_of_renamed_stages(project()).size(), 2u);

  const auto keys = current_keys(project());
  ASSERT_EQ(keys.size(), 4u);
  ArtifactStore store(store_of(project()));
  KeyTerms terms = stage.terms;
  terms["stage"] = "decompose";
  terms.erase("input.relight");
  terms["input.decompose"] = "d";
  EXPECT_EQ(keys.at("decompose"), key_of(terms));
  const auto now = store.find("decompose", key_of(terms));
  ASSERT_TRUE(now.has_value());
  EXPECT_EQ(now->stage, "decompose");
  EXPECT_EQ(now->version, 3);
  EXPECT_EQ(store.damage(store.entry("decompose", now->key)), "");
  EXPECT_EQ(read_file(store.entry("decompose", now->key) / kTimingName), "{\"seconds\": 5}\n");
  EXPECT_EQ(read_file(project() / "decompose/sub/a.txt"), "of relight");
  EXPECT_FALSE(fs::exists(project() / "relight"));
  EXPECT_TRUE(store.find("relight", stage.key).has_value()) << "nothing is lost";

  // The program's pictures stay where they are.
  EXPECT_EQ(read_file(project() / "relit/sky/b.txt"), "of relit");
  EXPECT_EQ(store.find("relight", keys.at("relight"))->outputs.at(0).path, "relit/sky/b.txt");
  EXPECT_EQ(store.find("relight", keys.at("relight-edited"))->outputs.at(0).path, "relit/sun/c.txt");
  EXPECT_TRUE(keys.contains("mesh"));
  EXPECT_FALSE(has_results_of_renamed_stages(project()));
}

TEST_F(RenamedStages, FoldersOfThisVersionStayAsTheyAre) {
  put("decompose", "decompose/a.txt");
  put("relight", "relit/sky/b.txt");
  const auto keys = current_keys(project());
  EXPECT_FALSE(has_results_of_renamed_stages(project()));
  EXPECT_TRUE(adopt_results_of_renamed_stages(project()).empty());
  EXPECT_EQ(current_keys(project()), keys);
  // Pictures alone, whose stage was removed from the list: they are not taken for those of the stage of before.
  remove_current_key(project(), "decompose");
  adopt_results_of_renamed_stages(project());
  EXPECT_EQ(current_key(project(), "relight"), keys.at("relight"));
  EXPECT_FALSE(current_key(project(), "decompose").has_value());
}

TEST_F(RenamedStages, DamagedOrMissingResultsAreLeftToTheNextRun) {
  const Manifest m = put("relight", "relight/a.txt");
  const ArtifactStore store(store_of(project()));
  fs::remove(project() / "relight/a.txt");
  fs::remove(store.entry("relight", m.key) / "relight/a.txt");
  adopt_results_of_renamed_stages(project());
  EXPECT_TRUE(current_keys(project()).empty());
  EXPECT_FALSE(fs::exists(store.root() / "decompose"));

  set_current_key(project(), "relight", "gone");
  adopt_results_of_renamed_stages(project());
  EXPECT_TRUE(current_keys(project()).empty());
}

}  // namespace
}  // namespace vitrine
