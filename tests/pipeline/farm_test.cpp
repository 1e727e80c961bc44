// vitrine farm: plans, tasks of array jobs, states; with the three test stages.
#include <regex>

#include "tests/pipeline/sandbox.h"

namespace vitrine {
namespace {

class Farm : public Sandbox {
 protected:
  Farm() {
    for (const char* name : {"cup", "a vase", "key"}) capture(captures() / name);
    make_folders(captures() / "empty");
    for (const char* variable : kVariables) unsetenv(variable);
  }
  static constexpr const char* kVariables[] = {
      "SLURM_ARRAY_TASK_ID",  "SGE_TASK_ID",  "PBS_ARRAY_INDEX",     "LSB_JOBINDEX",      "AWS_BATCH_JOB_ARRAY_INDEX",
      "JOB_COMPLETION_INDEX", "PARALLEL_SEQ", "SLURM_CPUS_PER_TASK", "SLURM_MEM_PER_NODE"};
  ~Farm() override {
    for (const char* variable : kVariables) unsetenv(variable);
  }
  static void capture(const fs::path& at) {
    write_file(at / "1.jpg", "one of " + at.filename().string());
    write_file(at / "2.jpg", "two");
  }
  fs::path captures() const { return folder.path() / "captures"; }
  fs::path results() const { return folder.path() / "results"; }
  Outcome plan(std::vector<std::string> more = {}) const {
    std::vector<std::string> all{"farm", "plan", captures().string(), "-o", results().string()};
    all.insert(all.end(), more.begin(), more.end());
    return call(all);
  }
  Outcome task(const std::string& index = "auto") const { return call({"farm", "task", results().string(), "--index", index}); }
  std::string state() const { return call({"farm", "status", results().string()}).text; }
};

TEST_F(Farm, PlansATaskForEveryFolderOfPhotos) {
  capture(captures() / "with folder/photos");
  const Outcome o = plan({"--cores", "2", "--", "--set", "upper.word=farmed"});
  ASSERT_EQ(o.exit, 0) << o.text;
  EXPECT_TRUE(o.said("empty is left out")) << o.text;
  EXPECT_TRUE(o.said("4 tasks")) << o.text;
  const std::string table = read_file(results() / "tasks.tsv"), commands = read_file(results() / "tasks.txt");
  EXPECT_EQ(std::ranges::count(table, '\n'), 5);
  EXPECT_EQ(std::ranges::count(commands, '\n'), 4);
  EXPECT_NE(table.find("\n1\ta vase\t2\t2\t"), std::string::npos) << table;  // in the order of their names
  EXPECT_NE(commands.find("--set upper.word=farmed --threads 2"), std::string::npos) << commands;
  EXPECT_NE(commands.find((captures() / "with folder/photos").string()), std::string::npos) << commands;
  EXPECT_NE(state().find("0 of 4 are done"), std::string::npos) << state();
}

TEST_F(Farm, TasksFindTheirNumberInTheVariableOfTheEngine) {
  ASSERT_EQ(plan().exit, 0);
  const struct {
    const char *variable, *value, *capture;
  } cases[] = {{"SLURM_ARRAY_TASK_ID", "1", "a vase"},
               {"SGE_TASK_ID", "2", "cup"},
               {"PBS_ARRAY_INDEX", "3", "key"},
               {"LSB_JOBINDEX", "1", "a vase"},
               {"AWS_BATCH_JOB_ARRAY_INDEX", "0", "a vase"},
               {"JOB_COMPLETION_INDEX", "1", "cup"},
               {"PARALLEL_SEQ", "3", "key"}};
  for (const auto& c : cases) {
    fs::remove_all(results() / c.capture);
    setenv(c.variable, c.value, 1);
    const Outcome o = task();
    unsetenv(c.variable);
    EXPECT_EQ(o.exit, 0) << c.variable << "\n" << o.text;
    EXPECT_TRUE(fs::exists(results() / c.capture / "run.json")) << c.variable;
  }
  EXPECT_NE(state().find("3 of 3 are done"), std::string::npos) << state();
}

TEST_F(Farm, TheStateNamesWhatFailedAndWhatIsGone) {
  ASSERT_EQ(plan({"--", "--set", "upper.fail=input"}).exit, 2) << "an option that no stage has";
  EXPECT_FALSE(fs::exists(results() / "tasks.tsv"));
  ASSERT_EQ(plan().exit, 0);
  EXPECT_EQ(task("2").exit, 0);
  fs::remove_all(captures() / "key");
  EXPECT_EQ(task("3").exit, 3);
  const std::string text = state();
  EXPECT_NE(text.find("1 of 3 are done"), std::string::npos) << text;
  EXPECT_TRUE(std::regex_search(text, std::regex("cup +all"))) << text;
  EXPECT_TRUE(std::regex_search(text, std::regex("a vase +- .*not begun"))) << text;
  EXPECT_TRUE(std::regex_search(text, std::regex("key .*its photos are gone"))) << text;
  const std::string page = read_file(results() / "index.html");
  EXPECT_LT(page.find("key"), page.find(">cup<")) << "what is done comes last";
  EXPECT_NE(page.find("cup/report.html"), std::string::npos);
}

TEST_F(Farm, CoresAndMemoryAreThoseThatTheEngineGives) {
  ASSERT_EQ(plan().exit, 0);
  setenv("SLURM_ARRAY_TASK_ID", "2", 1);
  setenv("SLURM_CPUS_PER_TASK", "1", 1);
  setenv("SLURM_MEM_PER_NODE", "3000", 1);
  ASSERT_EQ(task().exit, 0);
  const std::string run = read_file(results() / "cup/run.json");
  EXPECT_NE(run.find("\"--threads\",\n  \"1\""), std::string::npos) << run;
  EXPECT_NE(run.find("3000MiB"), std::string::npos) << run;
}

TEST_F(Farm, BadCallsAreRefusedBeforeAnythingIsWritten) {
  capture(folder.path() / "more/cup");
  const auto expect = [](const Outcome& o, int exit, const char* says) {
    EXPECT_EQ(o.exit, exit) << o.text;
    EXPECT_TRUE(o.said(says)) << o.text;
  };
  expect(plan({(folder.path() / "more").string()}), 3, "two captures have the name 'cup'");
  expect(call({"farm", "plan", captures().string(), "-o", (captures() / "cup/results").string()}), 2, "inside a capture");
  expect(call({"farm", "plan", (folder.path() / "none").string(), "-o", results().string()}), 3, "no such folder of captures");
  expect(call({"farm", "plan", (captures() / "empty").string(), "-o", results().string()}), 3, "there is no capture");
  expect(call({"farm", "status", results().string()}), 3, "there is no plan");
  expect(call({"farm", "sow"}), 2, "plan, submit, task or status?");
  EXPECT_FALSE(fs::exists(results()));
  ASSERT_EQ(plan().exit, 0);
  expect(task(), 2, "no engine gives this task a number");
  expect(task("9"), 2, "there is no task 9");
  expect(task("two"), 2, "no number of a task");
  setenv("SLURM_ARRAY_TASK_ID", "1", 1);
  setenv("PARALLEL_SEQ", "2", 1);
  expect(task(), 2, "two engines give this task a number");
  unsetenv("SLURM_ARRAY_TASK_ID");
  unsetenv("PARALLEL_SEQ");
  expect(call({"farm", "submit", results().string()}), 2, "which engine?");
  write_file(results() / "tasks.tsv", "index\n");
  expect(call({"farm", "status", results().string()}), 3, "tasks.tsv:1");
}

}  // namespace
}  // namespace vitrine
