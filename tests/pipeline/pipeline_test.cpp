// The cache's promises and the messages of `vitrine`, through the real program and three small real stages.
#include <sys/stat.h>

#include <sstream>

#include "core/foundation/base/error.h"
#include "core/foundation/base/graphics_card.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/timer.h"
#include "pipeline/given_inputs.h"
#include "pipeline/graph.h"
#include "pipeline/measures_in_photos.h"
#include "tests/pipeline/sandbox.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

TEST_F(Sandbox, SecondRunDoesNothingAndSaysSo) {
  const Outcome first = run();
  ASSERT_EQ(first.exit, 0) << first.text;
  EXPECT_TRUE(first.has("[1/3] collect    3 files")) << first.text;
  EXPECT_TRUE(first.has("done in "));
  EXPECT_EQ(states(), (States{{"collect", "ran"}, {"upper", "ran"}, {"join", "ran"}}));
  EXPECT_TRUE(fs::exists(out() / "join/joined.txt"));
  const double before_s = cpu_seconds(RUSAGE_CHILDREN);  // CPU time: a busy machine must not decide
  const Outcome second = run();
  EXPECT_LT(cpu_seconds(RUSAGE_CHILDREN) - before_s, 2.0);
  EXPECT_EQ(second.exit, 0);
  EXPECT_TRUE(second.has("everything up to date")) << second.text;
  EXPECT_EQ(states(), (States{{"collect", "cached"}, {"upper", "cached"}, {"join", "cached"}}));
}

TEST_F(Sandbox, RenderWantsATrainedScene) {
  EXPECT_EQ(call({"render", folder.path().string()}).exit, 3);
  ASSERT_EQ(run().exit, 0);
  const Outcome untrained = call({"render", out().string()});
  EXPECT_EQ(untrained.exit, 3);
  EXPECT_TRUE(untrained.has("there is no trained scene yet")) << untrained.text;
  EXPECT_EQ(call({"render", out().string(), "more"}).exit, 2);
  const Outcome unlit = call({"relight", out().string(), "--env", "sky.exr"});
  EXPECT_EQ(unlit.exit, 3);
  EXPECT_TRUE(unlit.has("no such file")) << unlit.text;
  EXPECT_EQ(call({"relight", out().string()}).exit, 3);
  EXPECT_EQ(call({"relight", out().string(), "--turntable", "many"}).exit, 2);
}

TEST_F(Sandbox, ViewWantsATrainedScene) {
  EXPECT_EQ(call({"view", folder.path().string()}).exit, 3);
  const Outcome done = run();
  ASSERT_EQ(done.exit, 0);
  EXPECT_FALSE(done.has("view.html")) << done.text;  // nothing was trained, and nothing is said
  const Outcome untrained = call({"view", out().string()});
  EXPECT_EQ(untrained.exit, 3);
  EXPECT_TRUE(untrained.has("there is no trained scene to view yet")) << untrained.text;
  EXPECT_EQ(call({"view", out().string(), "more"}).exit, 2);
}

TEST_F(Sandbox, OneOptionRerunsExactlyItsDependants) {
  ASSERT_EQ(run().exit, 0);
  const Outcome dry = run({"--set", "upper.word=other", "--dry-run"});
  EXPECT_TRUE(dry.has("keep  collect")) << dry.text;
  EXPECT_TRUE(dry.has("run   upper      because option word \"none\" -> \"other\"")) << dry.text;
  EXPECT_TRUE(dry.has("run   join       because needs upper")) << dry.text;
  ASSERT_EQ(run({"--set", "upper.word=other"}).exit, 0);
  EXPECT_EQ(states(), (States{{"collect", "cached"}, {"upper", "ran"}, {"join", "ran"}}));
  ASSERT_EQ(run({"--set", "join.weights=[3]", "--set", "upper.word=other"}).exit, 0);
  EXPECT_EQ(states(), (States{{"collect", "cached"}, {"upper", "cached"}, {"join", "ran"}}));
  ASSERT_EQ(run().exit, 0);  // back again: all of it is still in the store
  EXPECT_EQ(states(), (States{{"collect", "cached"}, {"upper", "cached"}, {"join", "cached"}}));
}

TEST_F(Sandbox, OptionsThatDoNotChangeTheResultRerunNothing) {
  ASSERT_EQ(run().exit, 0);
  ASSERT_EQ(run({"--set", "collect.step_ms=1", "-j", "1", "--max-memory", "1GiB"}).exit, 0);
  EXPECT_EQ(states().at("collect"), "cached");
}

TEST_F(Sandbox, ADeviceConcernsTheStagesThatHaveIt) {
  if (find_graphics_card().card) GTEST_SKIP() << "there is a card";
  const Outcome without = run({"--device", "cuda"});
  EXPECT_EQ(without.exit, exit_code(ErrorKind::Device));
  EXPECT_TRUE(without.has("--device auto")) << without.text;
  EXPECT_FALSE(fs::exists(out())) << "nothing is computed before";
  ASSERT_EQ(run().exit, 0);
  ASSERT_EQ(run({"--device", "auto"}).exit, 0);
  EXPECT_EQ(states().at("upper"), "cached") << "as on the CPU";

  const TemporaryFolder driver;
  fs::create_symlink(VITRINE_FAKE_DRIVER, driver.path() / "libcuda.so.1");
  setenv("LD_LIBRARY_PATH", driver.path().c_str(), 1);
  ASSERT_EQ(run({"--device", "cuda"}).exit, 0);
  EXPECT_EQ(states(), (States{{"collect", "cached"}, {"upper", "ran"}, {"join", "cached"}}));
  EXPECT_TRUE(run({"--device", "cuda", "--dry-run"}).has("keep  upper"));
  ASSERT_EQ(run({"--device", "auto"}).exit, 0);
  EXPECT_EQ(states().at("upper"), "cached") << "as on the CPU";
  const Outcome wrong = run({"--device", "card"});
  EXPECT_EQ(wrong.exit, 2);
  EXPECT_TRUE(wrong.has("cpu, cuda, auto")) << wrong.text;
  unsetenv("LD_LIBRARY_PATH");
}

TEST_F(Sandbox, TouchingAPhotoRerunsNothingAndChangingItReruns) {
  ASSERT_EQ(run().exit, 0);
  fs::last_write_time(photos() / "a.jpg", fs::file_time_type::clock::now() - std::chrono::hours(1));
  EXPECT_TRUE(run().has("everything up to date"));
  write_file(photos() / "a.jpg", "ONE");  // same size and name: collect lists the same, so nothing after it runs
  const Outcome changed = run();
  EXPECT_EQ(states(), (States{{"collect", "ran"}, {"upper", "cached"}, {"join", "cached"}})) << changed.text;
  write_file(photos() / "d.jpg", "new");
  EXPECT_TRUE(call({"explain", out().string()}).has("collect    runs because input photos changed"));
  ASSERT_EQ(run().exit, 0);
  EXPECT_EQ(states(), (States{{"collect", "ran"}, {"upper", "ran"}, {"join", "ran"}}));
  fs::remove(photos() / "d.jpg");
  ASSERT_EQ(run().exit, 0);
  EXPECT_FALSE(fs::exists(out() / "names/d.jpg.txt")) << "a file of the earlier artifact stays behind";
}

TEST_F(Sandbox, MovingTheProjectKeepsTheCache) {
  ASSERT_EQ(run({"--set", "upper.word=kept"}).exit, 0);
  const fs::path moved = folder.path() / "elsewhere/new name";
  fs::create_directories(moved.parent_path());
  fs::rename(out(), moved);
  const Outcome again = call({"run", moved.string()});
  EXPECT_EQ(again.exit, 0);
  EXPECT_TRUE(again.has("everything up to date")) << again.text;
}

TEST_F(Sandbox, AProjectRemembersPhotosPresetAndOptions) {
  ASSERT_EQ(run({"--preset", "preview", "--set", "join.separator=a: #b"}).exit, 0);
  EXPECT_TRUE(call({"run", out().string()}).has("everything up to date"));
  EXPECT_TRUE(call({"status", out().string()}).has("everything up to date"));
  const Outcome show = call({"config", "show", out().string(), "--origin"});
  EXPECT_TRUE(show.has("word: quick  # preset preview (")) << show.text;
  EXPECT_TRUE(show.has("separator: \"a: #b\"  # " + (out() / "vitrine.yaml").string() + ":")) << show.text;
}

TEST_F(Sandbox, ACommandWithPhotosSetsTheProjectUpAnewUnlessItsSettingsWereEdited) {
  ASSERT_EQ(run({"--set", "upper.word=first"}).exit, 0);
  ASSERT_EQ(run({"--set", "join.weights=[7]"}).exit, 0);
  EXPECT_FALSE(read_file(out() / "upper/list.txt").ends_with("first"));
  const Outcome temporary = call({"run", out().string(), "--set", "upper.word=once"});
  EXPECT_TRUE(temporary.has("note: options on the command line hold for this run")) << temporary.text;
  ASSERT_EQ(call({"run", out().string()}).exit, 0);
  EXPECT_TRUE(read_file(out() / "upper/list.txt").ends_with("none"));
  write_file(out() / "vitrine.yaml", read_file(out() / "vitrine.yaml") + "upper:\n  word: by hand\n");
  ASSERT_EQ(run().exit, 0);
  EXPECT_TRUE(read_file(out() / "upper/list.txt").ends_with("by hand"));
  EXPECT_TRUE(read_file(out() / "vitrine.yaml").ends_with("by hand\n"));
}

TEST_F(Sandbox, LayersWinInTheirOrder) {
  ASSERT_EQ(run().exit, 0);
  const auto word = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"config", "show", out().string()});
    const Outcome o = call(more);
    const size_t at = o.text.find("  word: ");
    return at == std::string::npos ? o.text : o.text.substr(at + 8, o.text.find('\n', at) - at - 8);
  };
  EXPECT_EQ(word({}), "none");
  EXPECT_EQ(word({"--preset", "preview"}), "quick");
  write_file(folder.path() / "home/vitrine/config.yaml", "upper: {word: user}\n");
  EXPECT_EQ(word({"--preset", "preview"}), "user");
  write_file(out() / "vitrine.yaml", read_file(out() / "vitrine.yaml") + "upper:\n  word: project\n");
  EXPECT_EQ(word({}), "project");
  write_file(out() / "stages/upper.yaml", "word: stage_file\n");
  EXPECT_EQ(word({}), "stage_file");
  write_file(folder.path() / "a.yaml", "upper: {word: file_a}\n");
  write_file(folder.path() / "b.yaml", "upper: {word: file_b}\n");
  EXPECT_EQ(word({"-c", "b.yaml", "-c", "a.yaml"}), "file_a");
  setenv("VITRINE_SET", "upper.word=environment; join.weights=[1]", 1);
  EXPECT_EQ(word({"-c", "a.yaml"}), "environment");
  EXPECT_EQ(word({"-c", "a.yaml", "--set", "upper.word=flag"}), "flag");
  unsetenv("VITRINE_SET");
}

TEST_F(Sandbox, ResolvedConfigurationCanBeGivenBack) {
  ASSERT_EQ(run({"--preset", "preview", "--set", "join.weights=[0.5, 3]"}).exit, 0);
  const auto before = digests();
  fs::copy_file(out() / "config.resolved.yaml", folder.path() / "again.yaml");
  const fs::path second = folder.path() / "second";
  const Outcome o = call({"run", photos().string(), "-o", second.string(), "-c", "again.yaml"});
  ASSERT_EQ(o.exit, 0) << o.text;
  ArtifactStore store(store_of(second));
  for (const auto& [stage, key] : current_keys(second)) EXPECT_EQ(store.find(stage, key)->content_digest, before.at(stage));
}

TEST_F(Sandbox, RangesAndForce) {
  EXPECT_EQ(run({"--from", "join"}).exit, 2);
  ASSERT_EQ(run({"--to", "upper"}).exit, 0);
  EXPECT_FALSE(fs::exists(out() / "join"));
  ASSERT_EQ(run().exit, 0);
  ASSERT_EQ(run({"--only", "upper", "--force"}).exit, 0);
  EXPECT_EQ(states(), (States{{"collect", "kept"}, {"upper", "ran"}}));
  ASSERT_EQ(run({"--from", "upper", "--set", "collect.label=ignored here"}).exit, 0);
  EXPECT_EQ(states(), (States{{"collect", "kept"}, {"upper", "cached"}, {"join", "cached"}}));
  ASSERT_EQ(run({"--force"}).exit, 0);
  EXPECT_EQ(states(), (States{{"collect", "ran"}, {"upper", "ran"}, {"join", "ran"}}));
  const Outcome typo = run({"--from", "uper"});
  EXPECT_EQ(typo.exit, 2);
  EXPECT_TRUE(typo.has("there is no stage 'uper'; did you mean 'upper'?")) << typo.text;
}

TEST_F(Sandbox, DamageIsNoticedAndRepaired) {
  ASSERT_EQ(run().exit, 0);
  const auto before = digests();
  std::ofstream(out() / "upper/list.txt") << "edited in place";  // a hard link into the store
  EXPECT_TRUE(call({"status", out().string()}).has("damaged"));
  const Outcome again = run();
  EXPECT_EQ(again.exit, 0);
  EXPECT_TRUE(again.has("the stored result of 'upper' is damaged")) << again.text;
  EXPECT_EQ(states(), (States{{"collect", "cached"}, {"upper", "ran"}, {"join", "cached"}}));
  EXPECT_EQ(digests(), before);
  fs::remove(out() / "join/joined.txt");
  ASSERT_EQ(run().exit, 0);
  EXPECT_TRUE(fs::exists(out() / "join/joined.txt"));
  std::ofstream(store_of(out()) / "join" / *current_key(out(), "join") / "manifest.json") << "{";
  EXPECT_EQ(run().exit, 0);
  EXPECT_EQ(digests(), before);
}

TEST_F(Sandbox, TyposInYamlAreShownWithTheirLine) {
  ASSERT_EQ(run().exit, 0);
  write_file(folder.path() / "kettle.yaml", "collect:\n  repeat: 12k\nupper:\n  wrod: x\n");
  const Outcome o = call({"run", out().string(), "-c", "kettle.yaml"});
  EXPECT_EQ(o.exit, 2);
  EXPECT_EQ(
      o.text,
      "kettle.yaml:2:11: error: 'collect.repeat' must be an integer between 1 and 100000, got \"12k\"\n"
      "    2 |   repeat: 12k\n"
      "      |           ^~~\n"
      "kettle.yaml:4:3: error: unknown key 'upper.wrod'; did you mean 'upper.word'?\n"
      "    4 |   wrod: x\n"
      "      |   ^~~~\n"
      "2 errors\n"
      "  try    `vitrine config reference` prints all options; `vitrine config show --origin` where each value came from\n");
  EXPECT_EQ(run({"--set", "collect.repeat=0"}).exit, 2);
  EXPECT_TRUE(run({"--set", "collect.repeat=0"})
                  .has("--set: error: 'collect.repeat' must be an integer between 1 and 100000, got \"0\""));
  EXPECT_TRUE(run({"--set", "colect.repaet=2"}).has("unknown key 'colect.repaet'; did you mean 'collect.repeat'?"));
  EXPECT_TRUE(run({"--set", "colect.xyz=2"}).has("unknown key 'colect.xyz'; did you mean 'collect'?"));
  EXPECT_TRUE(run({"--set", "collect.label=forbidden"}).has("collect.label must not be \"forbidden\""));
  EXPECT_TRUE(
      run({"--preset", "previw"}).has("'preset' must be one of preview, standard, got \"previw\"; did you mean \"preview\"?"));
}

TEST_F(Sandbox, FailuresOfAStagePassThrough) {
  const Outcome sfm = run({"--set", "collect.fail=input"});
  EXPECT_EQ(sfm.exit, 4);
  EXPECT_TRUE(sfm.has("[1/3] collect    FAILED  SFM_TOO_FEW\n")) << sfm.text;
  EXPECT_TRUE(sfm.has("error: 9 of 52 images have poses\n  where  photos\n  why    no texture\n  try    more photos\n"))
      << sfm.text;
  EXPECT_EQ(states(), (States{{"collect", "failed"}}));
  const Outcome killed = run({"--set", "collect.fail=crash"});
  EXPECT_EQ(killed.exit, 6);
  EXPECT_TRUE(killed.has("stage 'collect' was killed"));
  EXPECT_EQ(run({"--set", "collect.fail=memory"}).exit, 6);
  EXPECT_EQ(run({"--set", "collect.fail=check"}).exit, 1);
  EXPECT_EQ(run().exit, 0);
}

TEST_F(Sandbox, BadPlacesAreRefusedClearly) {
  EXPECT_EQ(call({"run", "nowhere"}).exit, 3);
  EXPECT_EQ(call({"run"}).exit, 2);
  EXPECT_EQ(call({"status", photos().string()}).exit, 3);
  using Words = std::vector<std::string>;
  for (const Words& words : {Words{"status", "a", "b"}, Words{"explain", "a", "b", "c"}, Words{"cache", "du", "a", "b"},
                             Words{"config", "show", "a", "b"}, Words{"doctor", "a"}, Words{"run", "a", "b"}}) {
    const Outcome o = call(words);
    EXPECT_EQ(o.exit, 2) << o.text;
    EXPECT_TRUE(o.has("unexpected argument \"" + words.back() + "\"")) << o.text;
  }
  fs::create_directories(folder.path() / "empty");
  const Outcome empty = call({"run", "empty", "-o", out().string()});
  EXPECT_EQ(empty.exit, 3);
  EXPECT_TRUE(empty.has("no photos in the folder")) << empty.text;
  EXPECT_EQ(call({"run", photos().string(), "-o", (photos() / "out").string()}).exit, 2);
  EXPECT_EQ(call({"run", photos().string(), "-o", "/proc/out"}).exit, 6);
  EXPECT_EQ(call({"runn"}).exit, 2);
  EXPECT_TRUE(run({"--poses", "x"}).has("--poses is of no use here: no stage reads 'poses'"));
  EXPECT_EQ(run({"--set", "input.notes=/no/such/file"}).exit, 3);
}

TEST(PrintedKey, IsFoundBetweenWhatLibrariesSay) {
  const std::string answer = "{\n \"key\": \"ab12\",\n \"terms\": {\n  \"stage\": \"mesh\"\n }\n}\n";
  for (const std::string& said : {answer, "{} of cpus\n{a: b}\n" + answer, answer + "bye {\n"}) {
    const auto key = printed_key(said);
    ASSERT_TRUE(key) << said;
    EXPECT_EQ(key->key, "ab12");
    EXPECT_EQ(key->terms, (KeyTerms{{"stage", "mesh"}}));
  }
  EXPECT_FALSE(printed_key("no key\n"));
  EXPECT_FALSE(printed_key("{\n \"key\": \"ab12\"\n"));
  EXPECT_FALSE(printed_key("{\n \"version\": 1\n}\n"));
}

TEST_F(Sandbox, AGreyCardIsLookedAtBeforeAnythingIsComputed) {
  EXPECT_TRUE(run({"--grey-card", "a.jpg:1,2,3,4"}).has("--grey-card is of no use here: no stage reads 'grey_card'"));
  write_file(photos() / "d.exr", "five");
  write_file(photos() / "a.png", "nine");  // the second photo with this stem keeps its extension in it
  for (const char* good : {"a.jpg:0,0,1,1", "a:410,220,60,40", "ä b.jpg:1,2,3,4", "a_png.png:1,2,3,4", "d.png:1,2,3,4"})
    EXPECT_NO_THROW(check_grey_card(good, photos())) << good;
  for (const char* bad : {"a.jpg", "a.jpg:1,2,3", "a.jpg:1,2,3,4,5", "a.jpg:1,2,0,4", "a.jpg:-1,2,3,4", "a.jpg:1 2 3 4",
                          ":1,2,3,4", "a.jpg:1,2,3,99999999999", "d.jpg:1,2,3,4", "a.png:1,2,3,4"}) {
    const Error e = error_of([&] { check_grey_card(bad, photos()); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << bad;
    EXPECT_EQ(e.detail().code, "GREY_CARD");
    EXPECT_EQ(e.detail().where, bad);
  }
  EXPECT_EQ(error_of([&] { check_grey_card("ä_b.jpg:1,2,3,4", photos()); }).detail().hint, "did you mean 'ä b.jpg'?");
  EXPECT_NO_THROW(check_grey_card("a.jpg:1,2,3,4", folder.path() / "nowhere"));
}

TEST_F(Sandbox, AScaleBarIsLookedAtBeforeAnythingIsComputed) {
  EXPECT_TRUE(
      run({"--scale-bar", "a.jpg:1,2,3,4 c.jpg:1,2,3,4 = 5cm"}).has("--scale-bar is of no use here: no stage reads 'scale_bar'"));
  for (const char* good : {"a.jpg:1,2,3,4 c.jpg:1,2,3,4 = 5cm", "a:1,2,3,4 ä b.jpg:1,2,3,4=50mm"})
    EXPECT_NO_THROW(check_scale_bar(good, photos())) << good;
  for (const char* bad : {"a.jpg:1,2,3,4 = 5cm", "a.jpg:1,2,3,4 c.jpg:1,2,3,4", "a.jpg:1,2,3,4 z.jpg:1,2,3,4 = 5cm"}) {
    const Error e = error_of([&] { check_scale_bar(bad, photos()); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << bad;
    EXPECT_EQ(e.detail().code, "SCALE_BAR");
    EXPECT_EQ(e.detail().where, bad);
  }
  EXPECT_EQ(error_of([&] { check_scale_bar("a.jpg:1,2,3,4 ä_b.jpg:1,2,3,4 = 5cm", photos()); }).detail().hint,
            "did you mean 'ä b.jpg'?");
  EXPECT_NO_THROW(check_scale_bar("a.jpg:1,2,3,4 c.jpg:1,2,3,4 = 5cm", folder.path() / "nowhere"));
}

TEST_F(Sandbox, OptionalInputsTakePart) {
  write_file(folder.path() / "notes.txt", "Remember\n");
  ASSERT_EQ(run({"--set", "input.notes=notes.txt"}).exit, 0);
  EXPECT_TRUE(read_file(out() / "collect/list.txt").starts_with("\nRemember\n"));
  ASSERT_EQ(call({"run", out().string(), "--set", "input.notes=none"}).exit, 0);
  EXPECT_EQ(states().at("collect"), "ran");
  // A file of a kind that the stage leaves to others is none of its inputs.
  for (const char* skipped : {"notes.yaml", "notes.yml"}) {
    write_file(folder.path() / skipped, "Remember\n");
    ASSERT_EQ(call({"run", out().string(), "--set", std::string("input.notes=") + skipped}).exit, 0);
    EXPECT_EQ(states().at("collect"), "cached") << skipped;
  }
}

TEST_F(Sandbox, JsonRecordsTellTheWholeRun) {
  const Outcome o = run({"--log-format", "json", "--no-progress"});
  ASSERT_EQ(o.exit, 0);
  std::istringstream lines(o.text);
  std::map<std::string, int> seen;
  for (std::string line; std::getline(lines, line);) {
    const auto e = nlohmann::json::parse(line);
    EXPECT_EQ(e.at("v"), kEventsVersion);
    ++seen[e.at("type")];
  }
  EXPECT_EQ(seen["run_start"], 1);
  EXPECT_EQ(seen["stage_end"], 3);
  EXPECT_EQ(seen["run_end"], 1);
  EXPECT_EQ(read_file(out() / "events.jsonl"), o.text);
}

TEST_F(Sandbox, LinesFitEightyColumnsWhenPiped) {
  const Outcome o = run({"--set", "collect.repeat=3"});
  std::istringstream lines(o.text);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(!line.starts_with("[") || line.size() <= 80) << line;
  }
  EXPECT_EQ(o.text.find('\033'), std::string::npos);
}

TEST_F(Sandbox, PruneKeepsWhatIsCurrent) {
  ASSERT_EQ(run().exit, 0);
  ASSERT_EQ(run({"--set", "upper.word=x"}).exit, 0);
  EXPECT_EQ(ArtifactStore(store_of(out())).entries().size(), 5u);
  EXPECT_TRUE(call({"cache", "du", out().string()}).has("current"));
  EXPECT_EQ(call({"cache", "prune", out().string()}).exit, 0);
  EXPECT_EQ(ArtifactStore(store_of(out())).entries().size(), 3u);
  EXPECT_TRUE(run({"--set", "upper.word=x"}).has("everything up to date"));
}

TEST_F(Sandbox, DryRunWritesNothing) {
  const Outcome o = run({"--dry-run"});
  EXPECT_EQ(o.exit, 0) << o.text;
  EXPECT_TRUE(o.has("run   collect    because not computed yet")) << o.text;
  EXPECT_FALSE(fs::exists(out()));
}

}  // namespace
}  // namespace vitrine
