// What people and programs read of a run: records that obey their schema, help that fits one template, and a console that stays
// readable at 80 columns, without colours, without a terminal.
#include <pty.h>

#include <algorithm>
#include <sstream>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "tests/pipeline/sandbox.h"
#include "tests/support/json_schema.h"

namespace vitrine {
namespace {

const fs::path kConfigs = fs::path(VITRINE_SOURCE_DIR) / "configs";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

class Console : public Sandbox {
 protected:
  // A run on a terminal of 80 columns, in an environment of its own. What it wrote, as it wrote it.
  Outcome on_terminal(const std::vector<std::string>& arguments, const std::vector<std::pair<const char*, const char*>>& more) {
    const std::vector<std::string> all = words(arguments);
    winsize size{.ws_row = 25, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
    int terminal = -1;
    const pid_t child = forkpty(&terminal, nullptr, nullptr, &size);
    if (child == 0) {
      for (const char* name : {"CI", "NO_COLOR"}) unsetenv(name);
      setenv("TERM", "xterm", 1);
      for (const auto& [name, value] : more) setenv(name, value, 1);
      std::vector<char*> argv;
      for (const std::string& w : all) argv.push_back(const_cast<char*>(w.c_str()));
      argv.push_back(nullptr);
      execv(argv[0], argv.data());
      _exit(99);
    }
    Outcome o;
    char buffer[4096];
    for (ssize_t n; (n = read(terminal, buffer, sizeof buffer)) > 0;) o.text.append(buffer, size_t(n));
    close(terminal);
    o.exit = wait_for(child);
    return o;
  }
  Outcome run_on_terminal(const std::vector<std::pair<const char*, const char*>>& more) {
    return on_terminal({"run", photos().string(), "-o", out().string(), "--force", "--set", "collect.repeat=30", "--set",
                        "collect.step_ms=40", "--set", "collect.warn=true"},
                       more);
  }
  // Columns of the widest line; what is redrawn on a line counts from its last return of the carriage.
  static size_t widest(const std::string& text) {
    size_t most = 0;
    for (const std::string& line : lines_of(text)) {
      size_t columns = 0;
      for (size_t i = 0; i < line.size(); ++i) {
        if (line[i] == '\r')
          columns = 0;
        else if (line[i] == '\033')
          i = std::min(line.find_first_of("mK", i), line.size());
        else
          columns += (static_cast<unsigned char>(line[i]) & 0xc0) != 0x80;
        most = std::max(most, columns);
      }
    }
    return most;
  }
};

TEST_F(Console, IsReadableInEightyColumnsWithAndWithoutColoursAndWhenPiped) {
  const Outcome coloured = run_on_terminal({});
  ASSERT_EQ(coloured.exit, 0) << coloured.text;
  EXPECT_TRUE(coloured.has("\033[32mok\033[0m")) << coloured.text;
  EXPECT_TRUE(coloured.has("\033[33mwarning:\033[0m"));
  EXPECT_TRUE(coloured.has("#-")) << "a bar that is redrawn";
  EXPECT_LE(widest(coloured.text.substr(0, coloured.text.find("done in"))), 80u) << coloured.text;
  const Outcome plain = run_on_terminal({{"NO_COLOR", "1"}});
  EXPECT_FALSE(plain.has("\033[3")) << plain.text;
  EXPECT_TRUE(plain.has("#-")) << "NO_COLOR is about colours alone";
  for (const auto& setting : {std::pair{"CI", "true"}, std::pair{"TERM", "dumb"}}) {
    const Outcome quiet = run_on_terminal({setting});
    EXPECT_EQ(quiet.text.find('\033'), std::string::npos) << setting.first << "\n" << quiet.text;
    EXPECT_FALSE(quiet.has("#-")) << setting.first;
    EXPECT_TRUE(quiet.has("] collect ")) << setting.first;
  }
  const Outcome piped = run({"--force", "--set", "collect.warn=true"});
  EXPECT_EQ(piped.text.find('\033'), std::string::npos);
  EXPECT_LE(widest(piped.text.substr(0, piped.text.find("done in"))), 80u) << piped.text;
  EXPECT_TRUE(piped.said("what the stage has to say is long enough to need a second line on a console of eighty columns"));
  // The log has it whole.
  EXPECT_NE(read_file(out() / "log.txt").find("say is long enough to need a second line on a console of eighty columns"),
            std::string::npos);
}

TEST_F(Console, EveryRecordObeysTheSchema) {
  const auto schema = nlohmann::json::parse(read_file(kConfigs / "events.schema.json"));
  ASSERT_EQ(
      run({"--log-format", "json", "--set", "collect.repeat=3", "--set", "collect.step_ms=1", "--set", "collect.warn=true"}).exit,
      0);
  ASSERT_EQ(run({"--set", "collect.fail=input"}).exit, 4);
  ASSERT_EQ(run().exit, 0);
  std::set<std::string> seen;
  for (const std::string& line : lines_of(read_file(out() / "events.jsonl"))) {
    const auto event = nlohmann::json::parse(line);
    EXPECT_EQ(test::schema_complaint(event, schema), "") << line;
    seen.insert(event.at("type"));
  }
  for (const auto& record : schema.at("oneOf")) {
    const std::string type = record.at("properties").at("type").at("const");
    EXPECT_TRUE(seen.contains(type)) << "no run of this test wrote a record '" << type << "'";
  }
  // The schema is one that can be broken.
  const std::string start = R"({"v": 2, "type": "stage_start", "time": "2026-01-01T00:00:00Z", "stage": "a", "key": )";
  EXPECT_EQ(test::schema_complaint(nlohmann::json::parse(start + "\"0f\"}"), schema), "");
  for (const char* wrong : {"7}", "\"x y\"}", "\"0f\", \"more\": 1}"})
    EXPECT_NE(test::schema_complaint(nlohmann::json::parse(start + wrong), schema), "") << wrong;
}

TEST(EventsSchema, ChangesWithItsVersionOnly) {
  const std::string schema = read_file(kConfigs / "events.schema.json");
  std::map<int, std::string> digests;
  for (const std::string& line : lines_of(read_file(kConfigs / "events.digests"))) {
    std::istringstream words(line);
    int version = 0;
    if (words >> version) words >> digests[version];
  }
  EXPECT_EQ(digests[kEventsVersion], sha256_hex(schema))
      << "the schema changed: raise kEventsVersion (core/foundation/base/json.h) and add a line to configs/events.digests";
  EXPECT_EQ(digests.rbegin()->first, kEventsVersion);
  const auto parsed = nlohmann::json::parse(schema);
  for (const auto& record : parsed.at("oneOf")) EXPECT_EQ(record.at("properties").at("v").at("const"), kEventsVersion);
}

TEST_F(Console, RunJsonTellsWhatWasRunOnWhatAndHowLong) {
  ASSERT_EQ(run({"--set", "upper.word=told"}).exit, 0);
  const auto r = nlohmann::json::parse(read_file(out() / "run.json"));
  for (const char* field : {"format", "vitrine", "command", "started", "finished", "seconds", "exit", "licence"})
    EXPECT_TRUE(r.contains(field)) << field;
  EXPECT_GT(r.at("machine").at("memory_bytes"), 1 << 20);
  EXPECT_GT(r.at("peak_rss_bytes"), 1 << 20);
  EXPECT_EQ(r.at("options").at("upper.word"), (nlohmann::json{{"value", "told"}, {"origin", "--set"}}));
  ASSERT_EQ(r.at("stages").size(), 3u);
  for (const auto& stage : r.at("stages")) {
    EXPECT_GE(stage.at("version"), 1);
    EXPECT_FALSE(stage.at("content_digest").get<std::string>().empty());
    EXPECT_FALSE(stage.at("inputs").empty()) << stage;
    EXPECT_GT(stage.at("seconds"), 0);
    EXPECT_GT(stage.at("peak_rss_bytes"), 1 << 20);
  }
  EXPECT_EQ(r.at("stages")[1].at("inputs").at("collect"), r.at("stages")[0].at("content_digest"));
}

}  // namespace
}  // namespace vitrine
