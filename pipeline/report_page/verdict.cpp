#include "pipeline/report_page/figures.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>

#include "core/foundation/base/process.h"

namespace vitrine {

namespace {

// Figures that determine the verdict; others are shown and may be reported as weak.
constexpr std::string_view kDeciding[] = {"one_object", "registered", "gap", "psnr", "ssim"};
// Other figures that may be reported as weak.
constexpr std::string_view kNamed[] = {
    "region_transparent", "region_reflective", "region_rest", "region_object", "weakest",
    "reprojection",       "observations",      "mesh_border", "baked",         "neutral_shift"};
constexpr size_t kMostCauses = 6;  // maximum number of causes of a failure; photos without a pose are also listed below

// Description of a stage for messages.
std::string stage_in_words(const std::string& stage) {
  for (const DeclaredReport& d : declared_reports())
    if (d.stage == stage && !d.doing.empty()) return fmt::format("while {} ({})", d.doing, stage);
  return "during " + stage;
}

std::string capital(std::string text) {
  if (!text.empty()) text[0] = char(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const size_t begin = line.find_first_not_of(" \t");
    if (begin != std::string::npos) lines.push_back(line.substr(begin));
  }
  return lines;
}

// Extracts options of `vitrine run`, with their values and a leading blank, from a line of advice: "accept fewer: --set
// sfm.min_registered=0.3".
std::string options_in(const std::string& line) {
  constexpr std::string_view kOptions[] = {"--set", "--masks", "--poses"};
  std::istringstream in(line);
  std::string found, option;
  for (std::string word; in >> word;) {
    if (option.empty()) {
      const std::string name = word.substr(std::min(word.find_first_not_of("(`\"'"), word.size()));
      if (std::ranges::find(kOptions, name) != std::end(kOptions))
        option = name;
      else if (!found.empty())
        break;
      continue;
    }
    const std::string value = word.substr(0, word.find_last_not_of(",;.:)`\"'") + 1);
    const size_t equals = value.find('=');
    if (!value.empty() && (option != "--set" || (equals != std::string::npos && equals + 1 < value.size())))
      found += fmt::format(" {} {}", option, value);
    if (!found.empty() && value.size() < word.size()) break;
    option.clear();
  }
  return found;
}

Rating worst_deciding(const Figures& figures) {
  Rating worst = Rating::Good;
  for (std::string_view id : kDeciding)
    if (const Figure* f = figures.find(id))
      worst = std::max(worst, f->rating == Rating::Unknown ? Rating::Borderline : f->rating);
  return worst;
}

// Bad before borderline figures; within these the deciding ones first, then the weakest first.
std::vector<const Figure*> weak_figures(const Figures& figures) {
  std::vector<const Figure*> weak, others;
  const auto add = [&](std::string_view id, std::vector<const Figure*>& to) {
    if (const Figure* f = figures.find(id); f != nullptr && f->rating != Rating::Good) to.push_back(f);
  };
  for (std::string_view id : kDeciding) {
    const Figure* psnr = figures.find("psnr");  // SSIM adds nothing to a weak PSNR
    if (id != "ssim" || psnr == nullptr || psnr->rating == Rating::Good) add(id, weak);
  }
  for (std::string_view id : kNamed) add(id, others);
  // An unrated figure is no weakness of the scene. An unrated deciding figure is listed: the evidence is insufficient.
  std::erase_if(others, [](const Figure* f) { return f->rating == Rating::Unknown; });
  std::stable_sort(others.begin(), others.end(), [](const Figure* a, const Figure* b) {
    return place_on_scale(a->rule, a->value) < place_on_scale(b->rule, b->value);
  });
  weak.insert(weak.end(), others.begin(), others.end());
  const auto badness = [](const Figure* f) { return f->rating == Rating::Unknown ? Rating::Borderline : f->rating; };
  std::stable_sort(weak.begin(), weak.end(), [&](const Figure* a, const Figure* b) { return badness(a) > badness(b); });
  return weak;
}

WeakSpot weak_spot(const Figure& f) {
  const std::string note = f.note.empty() ? "" : fmt::format(" ({})", f.note);
  const std::string weak = f.rating == Rating::Unknown ? fmt::format("Not known to be right: {}.", f.unknown) : f.rule.weak;
  return {weak, fmt::format("{}: {}{}", f.rule.label, shown(f.rule, f.value), note)};
}

std::string how_well(const Figures& figures) {
  std::string text;
  if (const Figure* registered = figures.find("registered"))
    text = fmt::format("{} photos {}", registered->note,
                       registered->rating == Rating::Unknown ? "have a pose that hardly any point holds" : "found their place");
  if (const Figure* psnr = figures.find("psnr"))
    text += fmt::format("{}pictures from places that training never saw come out at {}{}", text.empty() ? "" : ", and ",
                        shown(psnr->rule, psnr->value), psnr->rating == Rating::Unknown ? ", measured on too few views" : "");
  else if (!text.empty())
    text += "; pictures from new places have not been measured";
  return text.empty() ? std::string() : capital(text) + ".";
}

class Commands {
 public:
  Commands(const RunOutcome& outcome, std::string project) : outcome_(outcome), project_(std::move(project)) {}
  std::string again(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"vitrine", "run", project_});
    return join_command(more);
  }
  // Command with more photos or masks: starts from the photo folder.
  std::string with_photos(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"vitrine", "run", outcome_.photos.empty() ? "PHOTOS" : outcome_.photos, "-o", project_};
    if (!outcome_.preset.empty()) words.insert(words.end(), {"--preset", outcome_.preset});
    if (!outcome_.masks.empty() && std::find(more.begin(), more.end(), "--masks") == more.end())
      words.insert(words.end(), {"--masks", outcome_.masks});
    words.insert(words.end(), more.begin(), more.end());
    return join_command(words);
  }
  std::string of(std::vector<std::string> words) const {
    words.insert(words.begin() + 1, project_);
    words.insert(words.begin(), "vitrine");
    return join_command(words);
  }
  // Next quality preset; empty at the highest.
  std::string better() const { return outcome_.preset == "preview" ? "standard" : outcome_.preset == "standard" ? "high" : ""; }

 private:
  const RunOutcome& outcome_;
  std::string project_;
};

void advise(const Figures& figures, const RunOutcome& outcome, const Commands& commands, Verdict& v) {
  const auto rating = [&](std::string_view id) {
    const Figure* f = figures.find(id);
    return f == nullptr || f->rating == Rating::Unknown ? Rating::Good : f->rating;
  };
  const auto unknown = [&](std::string_view id) {
    const Figure* f = figures.find(id);
    return f != nullptr && f->rating == Rating::Unknown;
  };
  const auto add = [&](std::string text, std::string command) { v.next.push_back({std::move(text), std::move(command)}); };
  if (rating("one_object") != Rating::Good)
    add(outcome.masks.empty()
            ? "Give masks of the object, a picture for each photo in a folder called object: then its own features join the "
              "passes."
            : "Add photos between the passes: of the sides that both show, from lower down or of the object on its side.",
        commands.with_photos(outcome.masks.empty() ? std::vector<std::string>{"--masks", "MASKS"} : std::vector<std::string>{}));
  if (unknown("registered"))
    add("Find the poses from the photos, without given ones, or check how the given ones are written: hardly any point shows "
        "that "
        "they are right.",
        commands.with_photos());
  if (unknown("psnr"))
    add("Take more photos: every eighth is held out to measure by, and one is too few.", commands.with_photos());
  if (rating("registered") != Rating::Good)
    add("Add photos between those that were left out (listed below) and their neighbours, then run again.",
        commands.with_photos());
  if (rating("gap") == Rating::Bad || rating("weakest") == Rating::Bad)
    add("Add photos around the weakest views: each surface wants to be seen by four or more photos from different places.",
        commands.with_photos());
  const bool shiny = rating("region_transparent") != Rating::Good || rating("region_reflective") != Rating::Good;
  const bool soft = rating("psnr") != Rating::Good || rating("ssim") != Rating::Good || rating("region_rest") != Rating::Good;
  if ((soft || shiny) && !commands.better().empty())
    add("Train longer and finer.", commands.again({"--preset", commands.better()}));
  if (outcome.masks.empty() && soft)
    add("If there is glass, bare metal or a mirror in the scene, mark it in two or three photos: this opens a page that "
        "saves the "
        "marks and shows what to run then.",
        commands.of({"mark", "--open"}));
  if (!outcome.masks.empty() && shiny)
    add("Look whether the masks of glass and metal fit the photos, and mark them where they do not.",
        commands.of({"mark", "--open"}));
  if (rating("reprojection") != Rating::Good)
    add("Take sharper photos with a fixed focus and nothing moving; leave blurred ones out.", commands.with_photos());
  if (const Figure* f = figures.find("neutral_shift"); f != nullptr && f->rating != Rating::Good)
    add(fmt::format("Compare {} with its render: something plain that is white or grey in the photo is not in the render. Take "
                    "photos with a fixed white balance and nothing overexposed, or leave this photo out.",
                    f->note),
        commands.with_photos());
  if (rating("gap") == Rating::Borderline) add("Take more photos, from places in between.", commands.with_photos());
  add("Look at it under another light, any HDRI of yours.", commands.of({"relight", "--env", "studio.exr", "--turntable", "24"}));
}

void tell_failure(const RunOutcome& outcome, const Commands& commands, Verdict& v) {
  const std::string stage = outcome.last_stage();
  v.mood = Mood::Unfinished;
  v.word = stage.empty() ? "It did not finish" : fmt::format("It failed {}", stage_in_words(stage));
  if (!outcome.failure) {
    v.sentence = fmt::format("The run ended with exit code {}.", outcome.exit);
    v.next.push_back({"log.txt has all messages. Run it again once the cause is gone.", commands.again()});
    return;
  }
  const StageFailure& f = *outcome.failure;
  v.sentence = capital(f.message);
  if (!v.sentence.empty() && std::string_view(".!?").find(v.sentence.back()) == std::string_view::npos) v.sentence += ".";
  for (const std::string& line : lines_of(f.why))
    if (v.weak.size() < kMostCauses) v.weak.push_back({capital(line), ""});
  for (std::string line : lines_of(f.hint)) {
    const size_t number = line.find_first_not_of("0123456789");  // "2. put a pattern ...": the page adds its own numbers
    if (number != std::string::npos && number > 0 && line.substr(number).starts_with(". ")) line.erase(0, number + 2);
    Advice& a = v.next.emplace_back();
    if (const std::string options = options_in(line); !options.empty()) a.command = commands.again() + options;
    a.text = capital(std::move(line));
  }
  if (v.next.empty()) v.next.push_back({"Run it again once the cause is gone; what was finished is kept.", commands.again()});
}

}  // namespace

Verdict verdict_of(const RunOutcome& outcome, const Figures& figures, const std::string& project) {
  const Commands commands(outcome, project);
  Verdict v;
  switch (outcome.ending) {
    case Ending::Failed:
      tell_failure(outcome, commands, v);
      return v;
    case Ending::Stopped:
    case Ending::CutOff: {
      const std::string stage = outcome.last_stage();
      const std::string during = stage.empty() ? "" : " " + stage_in_words(stage);
      v.mood = Mood::Unfinished;
      v.word = outcome.ending == Ending::Stopped ? fmt::format("It was stopped{}", during)
               : stage.empty()                   ? std::string("It has not finished")
                                                 : "It was last seen" + during;
      v.sentence = outcome.ending == Ending::Stopped ? "What was finished and the last checkpoint are kept."
                                                     : "The run still goes on, or it was killed; what was finished is kept.";
      v.next.push_back({"Continue where it ended.", commands.again()});
      return v;
    }
    case Ending::Unknown:
      v.mood = Mood::Unfinished;
      v.word = "Nothing has been run here";
      v.sentence = "There is no trace of a run in this folder.";
      v.next.push_back({"Give it photos.", commands.with_photos()});
      return v;
    case Ending::Done:
      break;
  }
  const Rating worst = worst_deciding(figures);
  const bool measured = figures.find("psnr") != nullptr;
  v.mood = !measured && worst == Rating::Good ? Mood::Unfinished : Mood(int(worst));
  v.word = !measured                     ? "So far so good"
           : worst == Rating::Good       ? "It worked"
           : worst == Rating::Borderline ? "It worked, with weak spots"
                                         : "It ran through, but the result is weak";
  if (!measured && worst != Rating::Good) v.word = "The start is weak";
  v.sentence = how_well(figures);
  if (v.sentence.empty()) v.sentence = "The requested stages are done; nothing has been measured yet.";
  for (const Figure* f : weak_figures(figures))
    if (v.weak.size() < kMostWeak) v.weak.push_back(weak_spot(*f));
  if (!measured) v.next.push_back({"Go on with the stages that follow.", commands.again()});
  if (measured || worst != Rating::Good) advise(figures, outcome, commands, v);
  return v;
}

}  // namespace vitrine
