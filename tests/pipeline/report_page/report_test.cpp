// report.html: what it says of good, weak, failed and damaged folders, and that nothing in a folder gets out of its quotes.
#include <set>

#include <gtest/gtest.h>

#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/json.h"
#include "pipeline/report_page/facts.h"
#include "pipeline/report_page/figures.h"
#include "pipeline/report_page/page.h"
#include "tests/pipeline/report_page/small_output.h"

namespace vitrine {
namespace {

using test::OutputDesc;
using test::page;
using test::write_output;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Verdict verdict(const OutputDesc& desc) {
  const TemporaryFolder folder;
  write_output(folder.path(), desc);
  const RunOutcome outcome = read_outcome(folder.path());
  return verdict_of(outcome, gather_figures(folder.path(), outcome), "out");
}

TEST(Thresholds, EveryFigureHasItsTwoBordersAndTheReadmeTellsThem) {
  const std::string readme = read_file(fs::path(VITRINE_SOURCE_DIR) / "pipeline/report_page/README.md");
  std::set<std::string> ids;
  for (const DeclaredReport& declared : declared_reports())
    for (const ReportFigure& r : declared.report.figures) {
      SCOPED_TRACE(declared.stage + " " + r.id);
      EXPECT_TRUE(ids.insert(r.id).second) << "two figures have the id";
      for (const std::string& text : {r.group, r.label, r.means, r.weak, r.value, declared.report.file})
        EXPECT_FALSE(text.empty());
      ASSERT_NE(r.good, r.fair);
      const double step = 1e-6 * (r.higher_is_better() ? 1 : -1);
      EXPECT_EQ(rate(r, r.good), Rating::Good);
      EXPECT_EQ(rate(r, r.good - step), Rating::Borderline);
      EXPECT_EQ(rate(r, r.fair), Rating::Borderline);
      EXPECT_EQ(rate(r, r.fair - step), Rating::Bad);
      EXPECT_NEAR(place_on_scale(r, r.good), 2.0 / 3, 1e-9);
      EXPECT_NEAR(place_on_scale(r, r.fair), 1.0 / 3, 1e-9);
      std::string row = fmt::format("| {} | {} |", r.label, thresholds_text(r));
      for (size_t at; (at = row.find("\u00a0")) != std::string::npos;) row.replace(at, 2, " ");
      EXPECT_TRUE(has(readme, row)) << "missing in README.md: " << row;
    }
  // By these the verdict decides, or names a weak spot; the trust in parts of the picture hangs on `gap` and `region_*`.
  for (const char* id :
       {"one_object", "registered", "gap", "psnr", "ssim", "region_transparent", "region_reflective", "region_rest",
        "region_object", "weakest", "reprojection", "observations", "mesh_border", "baked", "neutral_shift"})
    EXPECT_TRUE(ids.contains(id)) << id << ": no stage declares it";
  for (const DeclaredReport& declared : declared_reports()) EXPECT_FALSE(declared.doing.empty()) << declared.stage;
}

TEST(FactText, TakesValuesFromTheReportOrSaysNothing) {
  const TemporaryFolder folder;
  write_file(folder.path() / "r.json", R"({"n": 1234567, "one": 1, "ratio": 0.257, "word": "thick", "other": "odd",
      "layers": {"a": {"n": 1000}, "b": {"n": 20}}, "single": {"a": {"n": 5}}, "low": 3.1, "high": 13.1})");
  const Facts report = Facts::of_file(folder.path() / "r.json");
  const std::pair<const char*, const char*> texts[] = {{"plain", "plain"},
                                                       {"{n:n} points", "1\u202f234\u202f567 points"},
                                                       {"{ratio:2} or {ratio:0}", "0.26 or 0"},
                                                       {"{one:0} {one:piece,pieces}, {n:piece,pieces}", "1 piece, pieces"},
                                                       {"{word}, {word=thin,thick}", "thick, thick"},
                                                       {"{layers.*.n:n} ({layers.*.n:parts})", "1\u202f020 (1\u202f000 a, 20 b)"},
                                                       {"{low,high:1} dB", "13.1 dB"},
                                                       {"{high,low:1} dB", "13.1 dB"}};
  for (const auto& [text, wanted] : texts) EXPECT_EQ(fact_text(text, report).value_or("(nothing)"), wanted) << text;
  for (const char* text : {"{missing:n}", "{missing}", "{other=thin,thick}", "{single.*.n:parts}", "{low,missing:1}", "{word:1}"})
    EXPECT_FALSE(fact_text(text, report)) << text;
}

TEST(Html, EscapesWhatComesFromOutsideAndMendsWhatIsNoText) {
  EXPECT_EQ(escaped("<a href='x' & \"y\">"), "&lt;a href=&#39;x&#39; &amp; &quot;y&quot;&gt;");
  EXPECT_EQ(escaped("ä€😀"), "ä€😀");
  EXPECT_EQ(escaped("a\xff\xc0\xaf z\x01"), "a\uFFFD\uFFFD\uFFFD z\uFFFD");
  EXPECT_EQ(escaped("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD");  // a surrogate
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("\xff\xfe\xfd\xfc"), "//79/A==");
}

TEST(Facts, CsvWithQuotesAndNamesThatLeaveTheFolder) {
  const auto rows = rows_of_csv("name,psnr\n\"a,\"\"b\"\".jpg\",21.5\r\nc.jpg,\n");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].at("name"), "a,\"b\".jpg");
  EXPECT_EQ(number_of(rows[0].at("psnr")), 21.5);
  EXPECT_EQ(number_of(rows[1].at("psnr")), std::nullopt);
  EXPECT_TRUE(stays_below("left/a.jpg"));
  for (const char* name : {"", "/etc/passwd", "../a.jpg", "left/../../a.jpg"}) EXPECT_FALSE(stays_below(name)) << name;
  EXPECT_FALSE(stays_below(std::string("a\0.jpg", 6))) << "which the system would open as a";
}

TEST(Verdict, SaysHowItWentByTheFiguresThatDecide) {
  const Verdict good = verdict({});
  EXPECT_EQ(good.mood, Mood::Good);
  EXPECT_EQ(good.word, "It worked");
  EXPECT_TRUE(has(good.sentence, "3 of 3 photos found their place")) << good.sentence;
  EXPECT_TRUE(has(good.sentence, "30.0\u00a0dB")) << good.sentence;
  EXPECT_EQ(verdict({.psnr = 27, .train_psnr = 29}).mood, Mood::Good);
  EXPECT_EQ(verdict({.psnr = 26.99, .train_psnr = 28}).word, "It worked, with weak spots");
  EXPECT_EQ(verdict({.psnr = 22, .train_psnr = 23}).mood, Mood::Borderline);
  const Verdict bad = verdict({.psnr = 21.98, .train_psnr = 33});
  EXPECT_EQ(bad.mood, Mood::Bad);
  EXPECT_EQ(bad.weak.at(0).figure, "Training against new views: 11.0\u00a0dB (33.0 dB where it trained, 22.0 dB where not)");
  EXPECT_EQ(bad.next.at(0).command, "vitrine run 'my photos' -o out --preset preview");
  EXPECT_EQ(bad.next.at(1).command, "vitrine run out --preset standard");
  const Verdict soft = verdict({.psnr = 24, .train_psnr = 28, .ssim = 0.8});
  ASSERT_EQ(soft.weak.size(), kMostWeak);
  EXPECT_TRUE(has(soft.weak[0].figure, "Training against new views")) << soft.weak[0].figure;
  EXPECT_TRUE(has(soft.weak[1].figure, "New views, PSNR")) << soft.weak[1].figure;
  EXPECT_FALSE(has(soft.weak[2].figure, "SSIM")) << "PSNR has said it";
  const Verdict few = verdict({.registered = 2});
  EXPECT_EQ(few.mood, Mood::Borderline);
  EXPECT_TRUE(has(few.next.at(0).text, "left out"));
}

TEST(Verdict, NamesThePhotoWhoseWhiteIsColouredInTheRender) {
  const auto of = [](const char* neutral) {
    const TemporaryFolder folder;
    write_output(folder.path(), {});
    write_file(folder.path() / "eval/metrics.json",
               fmt::format(R"({{"heldout": {{"psnr": 30, "ssim": 0.95, "views": 2}}, "train": {{"psnr": 31, "ssim": 0.95,
                   "views": 1}}{}}})",
                           neutral));
    const RunOutcome outcome = read_outcome(folder.path());
    return verdict_of(outcome, gather_figures(folder.path(), outcome), "out");
  };
  const Verdict coloured = of(R"(, "neutral": {"shift": 0.46, "photo": "b.jpg", "views": 2})");
  EXPECT_EQ(coloured.weak.at(0).figure, "White stays white: 46\u00a0% (b.jpg)");
  EXPECT_TRUE(has(coloured.next.at(0).text, "Compare b.jpg with its render")) << coloured.next[0].text;
  for (const char* fine : {"", R"(, "neutral": {"shift": 0.05, "photo": "b.jpg", "views": 2})"}) {
    for (const WeakSpot& w : of(fine).weak) EXPECT_FALSE(has(w.figure, "White")) << fine;
    EXPECT_FALSE(has(of(fine).next.at(0).text, "Compare")) << fine;
  }
}

TEST(Figures, PosesAndTheirErrorAreNotRatedFromHardlyAnyPoint) {
  for (const int points : {0, 99}) {
    const TemporaryFolder folder;
    write_output(folder.path(), {.points = points});
    const Figures f = gather_figures(folder.path(), read_outcome(folder.path()));
    for (const char* id : {"registered", "reprojection"}) {
      const Figure* figure = f.find(id);
      ASSERT_NE(figure, nullptr) << id << " says that it is not known";
      EXPECT_EQ(figure->rating, Rating::Unknown) << id;
      EXPECT_EQ(figure->unknown, fmt::format("too few points ({})", points));
    }
    const std::string html = page(folder.path());
    EXPECT_TRUE(has(html, fmt::format("Unknown: too few points ({}).", points)));
    EXPECT_TRUE(has(html, "rating unknown"));
    EXPECT_FALSE(has(html, "nan"));
    const Verdict v = verdict({.points = points});
    EXPECT_EQ(v.mood, Mood::Borderline) << "not known to be right is not right";
    EXPECT_TRUE(has(v.sentence, "hardly any point")) << v.sentence;
    EXPECT_TRUE(has(v.weak.at(0).text, "too few points")) << v.weak.at(0).text;
  }
  const TemporaryFolder folder;
  write_output(folder.path(), {.points = 100});
  EXPECT_EQ(gather_figures(folder.path(), read_outcome(folder.path())).find("reprojection")->rating, Rating::Good);
}

TEST(Figures, OneHeldOutViewIsShownAndNotRated) {
  const TemporaryFolder folder;
  write_output(folder.path(), {.psnr = 40, .train_psnr = 40, .heldout_views = 1});
  const Figures f = gather_figures(folder.path(), read_outcome(folder.path()));
  for (const char* id : {"psnr", "ssim", "gap", "region_rest"}) EXPECT_EQ(f.find(id)->rating, Rating::Unknown) << id;
  EXPECT_EQ(f.find("psnr")->value, 40);
  const Verdict v = verdict({.psnr = 40, .train_psnr = 40, .heldout_views = 1});
  EXPECT_NE(v.mood, Mood::Good);
  EXPECT_TRUE(has(v.next.at(0).text, "Take more photos")) << v.next.at(0).text;
}

TEST(Figures, AMeshWithoutTrianglesHasNoGoodFigure) {
  const TemporaryFolder folder;
  write_output(folder.path());
  write_file(folder.path() / "mesh/report.json",
             R"({"mesh": {"faces": 0, "components": 0, "edges": 0, "boundary_edges": 0, "self_intersections": 0}})");
  EXPECT_EQ(gather_figures(folder.path(), read_outcome(folder.path())).find("mesh_crossing")->rating, Rating::Unknown);
}

TEST(Figures, SurfelsAreCountedOverAllLayers) {
  const TemporaryFolder folder;
  write_output(folder.path());
  const std::string one = page(folder.path());
  EXPECT_TRUE(has(one, "60\u202f000 surfels")) << one.substr(one.find("sparse points"), 300);
  EXPECT_FALSE(has(one, "by layer"));
  write_file(folder.path() / "optimize/report.json", R"({"surfels": 40000, "iterations": 3000, "layers":
      {"diffuse": {"surfels": 40000}, "reflection": {"surfels": 15000}, "transmittance": {"surfels": 6000}}})");
  const std::string html = page(folder.path());
  EXPECT_TRUE(has(html, "61\u202f000 surfels (by layer: 40\u202f000 diffuse, 15\u202f000 reflection, 6\u202f000 transmittance)"));
}

TEST(Figures, SurfelsAreThoseOfTheMeasurementWhereTheTrainingHasNoReport) {
  const TemporaryFolder folder;
  write_output(folder.path());
  fs::remove(folder.path() / "optimize/report.json");
  auto metrics = nlohmann::json::parse(read_file(folder.path() / "eval/metrics.json"));
  metrics["surfels"] = 51000;
  write_file(folder.path() / "eval/metrics.json", metrics.dump());
  EXPECT_TRUE(has(page(folder.path()), "51\u202f000 surfels"));
}

TEST(Verdict, OfAFailureNamesTheStageTheCauseAndWhatToTry) {
  const Verdict v = verdict(
      {.exit = 4,
       .events = "{\"type\":\"run_start\",\"version\":\"0.1.0\"}\n{\"type\":\"stage_start\",\"stage\":\"sfm\",\"key\":\"ab\"}\n"
                 "{\"type\":\"error\",\"stage\":\"sfm\",\"exit\":4,\"code\":\"X\",\"message\":\"2 of 7 photos have "
                 "poses\",\"why\":\"blur\\n  "
                 "dark\",\"hint\":\"1. add photos\\n 2. accept fewer: --set "
                 "sfm.min_registered=0.3\"}\n{\"type\":\"run_end\",\"exit\":4}\n"});
  EXPECT_EQ(v.mood, Mood::Unfinished);
  EXPECT_EQ(v.word, "It failed while finding the camera poses (sfm)");
  EXPECT_EQ(v.sentence, "2 of 7 photos have poses.");
  ASSERT_EQ(v.weak.size(), 2u);
  EXPECT_EQ(v.weak[1].text, "Dark");
  ASSERT_EQ(v.next.size(), 2u);
  EXPECT_EQ(v.next[0].text, "Add photos");
  EXPECT_EQ(v.next[1].command, "vitrine run out --set sfm.min_registered=0.3");
}

TEST(Verdict, AdviceBecomesACommandThatAShellTakes) {
  const std::pair<const char*, const char*> lines[] = {
      {"accept fewer: --set sfm.min_registered=0.3", " --set sfm.min_registered=0.3"},
      {"find the cameras without masks of a class: --set sfm.masks.specular=off (object, transparent, ignore)",
       " --set sfm.masks.specular=off"},
      {"mark the shiny parts: --masks marks.yaml (stages/masks/README.md), or a folder of masks", " --masks marks.yaml"},
      {"a turntable? give masks of the object: --masks DIR --set sfm.turntable=yes", " --masks DIR --set sfm.turntable=yes"},
      {"white means 'object' (--set masks.object.polarity=black turns it round); without such pixels: --set "
       "masks.object.source=none",
       " --set masks.object.polarity=black"},
      {"raise --max-memory or --set optimize.max_side=640", " --set optimize.max_side=640"},
      {"supply poses: --poses transforms.json, or a COLMAP model", " --poses transforms.json"},
      {"say it: --set normals.files.space= (or normals.onnx.space=) one of camera-opencv", ""},
      {"leave out --from and --only: what is missing is computed first", ""},
      {"manual exposure; `vitrine inspect PHOTOS --json` lists them", ""}};
  for (const auto& [line, options] : lines) {
    const Verdict v = verdict({.exit = 4,
                               .events = fmt::format("{{\"type\":\"run_start\"}}\n{{\"type\":\"error\",\"message\":\"x\","
                                                     "\"hint\":\"1. {}\"}}\n{{\"type\":\"run_end\",\"exit\":4}}\n",
                                                     line)});
    ASSERT_EQ(v.next.size(), 1u) << line;
    EXPECT_EQ(v.next[0].command, *options == 0 ? std::string() : fmt::format("vitrine run out{}", options)) << line;
  }
}

TEST(Verdict, OfARunThatWasStoppedOrKilledIsToGoOn) {
  const std::string start = "{\"type\":\"run_start\"}\n{\"type\":\"stage_start\",\"stage\":\"mesh\",\"key\":\"ab\"}\n";
  const Verdict stopped = verdict({.exit = 75, .events = start + "{\"type\":\"run_end\",\"exit\":75}\n"});
  EXPECT_EQ(stopped.word, "It was stopped while measuring (evaluate)");  // as run.json has it
  EXPECT_EQ(stopped.next.at(0).command, "vitrine run out");
  const Verdict killed = verdict({.events = "{\"type\":\"run_start\"}\n{\"type\":\"run_end\"}\n" + start});
  EXPECT_EQ(killed.word, "It was last seen while building the mesh (mesh)");
}

TEST(Page, HasEverySectionAndAsksTheNetworkForNothing) {
  const TemporaryFolder folder;
  write_output(folder.path(), {.registered = 2});
  const std::string html = page(folder.path());
  for (const char* id : {"verdict", "figures", "views", "regions", "layers", "mesh", "light", "cameras", "cost"})
    EXPECT_TRUE(has(html, fmt::format("<section id=\"{}\"", id))) << id;
  EXPECT_TRUE(has(html, "12 features &amp; too few (likely: blurred)"));
  EXPECT_TRUE(has(html, "few &lt;views&gt;"));
  EXPECT_TRUE(has(
      html, "<th scope=\"row\">case &lt;1&gt;</th><td>thin glass</td><td>marked</td><td>24.3\u00a0dB</td><td>93\u00a0%</td>"));
  EXPECT_TRUE(has(html, "<th scope=\"row\">kettle</th><td>mirror</td><td>given</td><td>21.7\u00a0dB</td><td>–</td>"));
  EXPECT_TRUE(has(html, "the glass looks thick (straight rays show what is behind it at 13.1 dB, refracted ones at 36.1 dB)"));
  EXPECT_TRUE(has(html, "default-src 'none'"));
  for (const char* outside : {"http://", "https://", "src=\"/", "url(", "@import", "<link"})
    EXPECT_FALSE(has(html, outside)) << outside;
  for (size_t at = 0; (at = html.find("<img", at)) != std::string::npos; ++at) {
    const std::string tag = html.substr(at, html.find('>', at) - at);
    EXPECT_TRUE(has(tag, "src=\"data:image/jpeg;base64,")) << tag.substr(0, 80);
    EXPECT_TRUE(has(tag, "alt=\"")) << tag.substr(0, 80);
  }
  EXPECT_EQ(page(folder.path()), html) << "the same folder gives the same page";
  EXPECT_LT(html.size(), size_t(200) << 10);
}

TEST(Page, OpensWithALargePictureAndTheWayToTheScene) {
  const TemporaryFolder folder;
  write_output(folder.path());
  const auto opening = [&] {
    const std::string html = page(folder.path());
    const size_t begin = html.find("<figure id=\"opening\">");
    EXPECT_LT(begin, html.find("<section id=\"verdict\"")) << "it comes first";
    return begin == std::string::npos ? std::string() : html.substr(begin, html.find("</figure>", begin) - begin);
  };
  EXPECT_TRUE(has(opening(), "The scene under the light studio, view a."));
  EXPECT_FALSE(has(opening(), "href")) << "there is no view.html";
  write_file(folder.path() / "view.html", "<html></html>");
  EXPECT_TRUE(has(opening(), "<a href=\"view.html\"><div"));
  EXPECT_TRUE(has(opening(), "Open the scene: any side, any light</a>"));
  fs::remove_all(folder.path() / "relit");
  write_ldr(folder.path() / "view_relit.jpg", test::plain_picture(64, 48, 50));
  EXPECT_TRUE(has(opening(), "under the light of the photos, turned by 150 degrees"));
  fs::remove(folder.path() / "view_relit.jpg");
  EXPECT_TRUE(has(opening(), "rendered from the camera of b.jpg, which training never saw")) << "the best of the held-out views";
  EXPECT_FALSE(has(page(folder.path()), "lazy")) << "pictures that wait are blank on paper";
}

TEST(Page, CommandsBreakBetweenWordsAndKeepEveryLetter) {
  const TemporaryFolder folder;
  write_output(folder.path(), {.psnr = 24, .train_psnr = 25});
  const std::string html = report_page({.project = folder.path(), .typed = "ö/a<b"});
  EXPECT_TRUE(has(html, "<span>run</span> <span>&#39;ö/a&lt;b&#39;</span> <span>--preset</span> <span>standard</span>"))
      << html.substr(html.find("<h1>"), 3000);
}

TEST(Page, APhotoMayBeCalledAnything) {
  const std::string name = "<script>alert('x')<b>\"&,.jpg";
  const TemporaryFolder folder;
  write_output(folder.path(), {.photo = name});
  const std::string html = page(folder.path());
  EXPECT_FALSE(has(html, "<script>alert"));
  EXPECT_TRUE(has(html, escaped(name)));
  EXPECT_TRUE(has(html, "Photo " + escaped(name))) << "its pictures are found";
  size_t scripts = 0;
  for (size_t at = 0; (at = html.find("<script", at)) != std::string::npos; ++at) ++scripts;
  EXPECT_EQ(scripts, 1u);
}

TEST(Page, IsMadeOfWhateverIsThere) {
  const TemporaryFolder whole;
  write_output(whole.path());
  std::vector<fs::path> files;
  for (const auto& e : fs::recursive_directory_iterator(whole.path()))
    if (e.is_regular_file()) files.push_back(e.path());
  ASSERT_GT(files.size(), 15u);
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    const std::string bytes = read_file(file);
    for (const std::string& instead : {std::string("[1, {\"photos\": 7, \"stages\": {}}]"), bytes.substr(0, bytes.size() / 2)}) {
      write_file(file, instead);
      EXPECT_TRUE(has(page(whole.path()), "</html>"));
    }
    fs::remove(file);
    EXPECT_TRUE(has(page(whole.path()), "</html>"));
    write_file(file, bytes);
  }
  const TemporaryFolder empty;
  EXPECT_TRUE(has(page(empty.path()), "Nothing has been run here"));
}

TEST(Outcome, LeavesOutNumbersThatNoRunHas) {
  const TemporaryFolder folder;
  write_file(folder.path() / "run.json",
             R"({"exit": 1e300, "machine": {"threads": -1e300}, "stages": [{"name": "mesh", "state": "ran", "seconds": -2,
                 "cpu_seconds": 1e40, "peak_rss_bytes": 1e300}]})");
  const RunOutcome o = read_outcome(folder.path());
  EXPECT_EQ(o.machine, "");
  ASSERT_EQ(o.stages.size(), 1u);
  EXPECT_FALSE(o.stages[0].seconds || o.stages[0].cpu_seconds || o.stages[0].peak_bytes);
  EXPECT_TRUE(has(page(folder.path()), "</html>"));
}

TEST(Page, ReadsNothingOutsideTheFolder) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  write_output(out);
  for (const char* what : {"gt", "pred"})
    write_ldr(folder.path() / fmt::format("secret_{}.png", what), test::plain_picture(8, 8, 1));
  write_file(out / "eval/per_view.csv", "name,set,psnr,ssim\n../../secret.jpg,heldout,20,0.9\n");
  EXPECT_FALSE(has(page(out), "class=\"compare\""));
  write_file(out / "eval/per_view.csv", "name,set,psnr,ssim\na.jpg,heldout,20,0.9\n");
  EXPECT_TRUE(has(page(out), "class=\"compare\""));
}

TEST(Page, KnowsWhetherItIsUpToDate) {
  const TemporaryFolder folder;
  write_output(folder.path());
  const PageDesc desc{.project = folder.path(), .typed = "out"};
  const fs::path file = folder.path() / "report.html";
  EXPECT_EQ(state_of_page(file), "");
  write_file(file, report_page(desc));
  EXPECT_EQ(state_of_page(file), page_state(desc));
  make_folders(folder.path() / ".cache");
  write_file(folder.path() / ".cache/current.json", "{\"mesh\": \"0b\"}");
  EXPECT_NE(state_of_page(file), page_state(desc));
}

}  // namespace
}  // namespace vitrine
