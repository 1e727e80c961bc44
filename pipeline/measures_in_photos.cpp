#include "pipeline/measures_in_photos.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/config/chart.h"
#include "core/scene/camera/scale_bar_length.h"
#include "core/scene/camera/view_set.h"
#include "pipeline/given_inputs.h"
#include "pipeline/project.h"

namespace vitrine {

namespace {

constexpr const char* kCardOption = "decompose.grey_card";
constexpr const char* kBarOption = "export.scale_bar";

// Text of the option; empty without such an option.
std::string text_of(const Settings& settings, const char* path) {
  const Option* option = settings.options.table.find(path);
  return option == nullptr ? "" : option->text();
}

int max_side_of(const Settings& settings) {
  const std::string text = text_of(settings, "ingest.max_side");
  int side = 0;
  std::from_chars(text.data(), text.data() + text.size(), side);
  return side;
}

// One of the measures, as given.
struct Measure {
  const char *what, *code;
  std::string text;
  const fs::path& photos;
  int max_side = 0;

  Error error(std::string why, std::string hint) const {
    return Error(ErrorKind::Usage, fmt::format("the {} cannot be found", what),
                 {.where = text, .why = std::move(why), .hint = std::move(hint), .code = code});
  }
};

// Checks the photo and the rightmost and lowest pixel coordinates in it. Returns a sentence if the photo is reduced.
std::string check_in_photo(const Measure& m, const PhotoNames& names, const std::string& photo, double right, double bottom) {
  // Undistorted photos of lenses with strong pincushion distortion are larger than ingested ones.
  constexpr double kUndistortedGrowth = 1.25;
  if (names.empty()) return {};  // photo folder unavailable: ingest reports that
  const auto index = names.find(photo);
  if (!index) {
    const std::string near = names.nearest(photo);
    throw m.error(fmt::format("no photo in {} is called '{}'", m.photos.string(), photo),
                  near.empty() ? "give the name of one of the photos" : fmt::format("did you mean '{}'?", near));
  }
  const auto full = names.pixels(*index);
  if (!full) return {};
  const Intrinsics reduced = Intrinsics{full->width, full->height, 1, 1, 0, 0}.limited_to(m.max_side);
  const double scale = double(reduced.width) / full->width;
  if (right <= kUndistortedGrowth * reduced.width && bottom <= kUndistortedGrowth * reduced.height)
    return scale == 1 ? ""
                      : fmt::format("the {} counts in pixels of images/{} (about {}x{}), not in those of the photo ({}x{})",
                                    m.what, names.name(*index), reduced.width, reduced.height, full->width, full->height);
  const bool in_full = right <= full->width && bottom <= full->height;
  throw m.error(fmt::format("it reaches to column {:.0f} and row {:.0f}, but images/{} has {}x{} pixels{}", right, bottom,
                            names.name(*index), reduced.width, reduced.height,
                            in_full ? fmt::format("; the photo has {}x{}", full->width, full->height) : ""),
                in_full ? fmt::format("multiply its coordinates by {:.4g}, or read them in images/ of the output folder", scale)
                        : "read its coordinates in images/ of the output folder, which a run with --to sfm writes");
}

}  // namespace

std::string check_grey_card(const std::string& text, const fs::path& photos, int max_side) {
  const Measure m{"grey card", "GREY_CARD", text, photos, max_side};
  const auto box = parse_photo_box(text);
  if (!box)
    throw m.error("it must read photo:x,y,w,h: four whole numbers, the box at least one pixel wide and high",
                  "for example IMG_0007.jpg:410,220,60,40, pixels of images/IMG_0007.jpg in the output folder");
  return check_in_photo(m, PhotoNames(photos), box->photo, double(box->x) + box->width, double(box->y) + box->height);
}

std::string check_scale_bar(const std::string& text, const fs::path& photos, int max_side) {
  const Measure m{"scale bar", "SCALE_BAR", text, photos, max_side};
  const ScaleBar bar = parse_scale_bar(text);
  const PhotoNames names(photos);
  std::string note;
  for (const ScaleBarMark& mark : bar.marks) {
    const std::string of_photo = check_in_photo(m, names, mark.photo, std::max(mark.x1, mark.x2), std::max(mark.y1, mark.y2));
    if (note.empty()) note = of_photo;
  }
  return note;
}

std::vector<std::string> check_measures(const Settings& settings) {
  std::vector<std::string> notes;
  const auto check = [&](const char* path, std::string (*checked)(const std::string&, const fs::path&, int)) {
    const std::string text = text_of(settings, path);
    if (text.empty()) return;
    const std::string note = checked(text, settings.text("input.photos"), max_side_of(settings));
    if (!note.empty() && settings.from_command.contains(path)) notes.push_back("note: " + note);
  };
  check(kCardOption, check_grey_card);
  check(kBarOption, check_scale_bar);
  return notes;
}

MeasuresOnce::MeasuresOnce(const Planner& planner, const Settings& settings, fs::path project)
    : planner_(planner), settings_(settings), project_(std::move(project)) {}

bool MeasuresOnce::chosen(const char* stage) const {
  return std::ranges::any_of(planner_.graph().nodes, [&](const StageNode& n) { return n.name == stage && planner_.chosen(n); });
}

void MeasuresOnce::operator()(size_t next) {
  const auto& nodes = planner_.graph().nodes;
  const auto sfm = std::ranges::find(nodes, "sfm", &StageNode::name);
  if (done_ || sfm == nodes.end() || next <= size_t(sfm - nodes.begin())) return;
  const auto key = current_key(project_, sfm->name);
  if (!key) return;
  done_ = true;
  const std::string card = text_of(settings_, kCardOption), bar = text_of(settings_, kBarOption);
  const bool of_card = !card.empty() && chosen("decompose"), of_bar = !bar.empty() && chosen("export");
  if (!of_card && !of_bar) return;
  const fs::path artifact = store_of(project_) / sfm->name / *key;
  const std::vector<View> views = read_transforms_json(artifact / "transforms.json");
  if (of_card) card_box(card, views);
  if (of_bar) scale_bar_length(parse_scale_bar(bar), views, read_passes(artifact));
}

}  // namespace vitrine
