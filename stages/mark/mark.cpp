#include "stages/mark/mark.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "core/foundation/config/yaml.h"
#include "core/intake/masks/photo_marks.h"
#include "stages/page_text.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kPage = "mark.html";

// The file as a JSON tree; the page interprets it and displays its marks.
Json tree_of(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::Scalar:
      return node.text;
    case YamlNode::Kind::List: {
      Json list = Json::array();
      for (const YamlNode& item : node.items) list.push_back(tree_of(item));
      return list;
    }
    case YamlNode::Kind::Map: {
      Json map = Json::object();
      for (const auto& [key, value] : node.entries) map[key.text] = tree_of(value);
      return map;
    }
    case YamlNode::Kind::Null:
      break;
  }
  return nullptr;
}

Json numbers(const Vec3d& v) { return {v.x, v.y, v.z}; }

// Camera position; its axes x, y, z; width and height of the picture at z = 1.
Json camera_json(const RunPhoto& photo) {
  const Intrinsics& k = photo.view.intrinsics;
  const Mat3d& r = photo.view.cam_from_world.rotation;
  const auto axis = [&](size_t row) { return numbers({r(row, 0), r(row, 1), r(row, 2)}); };
  return {{"eye", numbers(photo.view.centre_in_world())},
          {"right", axis(0)},
          {"down", axis(1)},
          {"ahead", axis(2)},
          {"across", photo.width / k.fx},
          {"along", photo.height / k.fy}};
}

Json photo_json(const PagePhoto& photo, const RunPhoto* known) {
  Json j{{"name", photo.name}, {"width", photo.width}, {"height", photo.height}};
  if (known == nullptr) return j;
  j["camera"] = camera_json(*known);
  Json masks = Json::object();
  for (MaskClass kind : kMaskClasses)
    if (const auto& runs = known->masks[size_t(kind)]) masks[std::string(name(kind))] = *runs;
  if (!masks.empty()) j["masks"] = {{"width", known->mask_width}, {"height", known->mask_height}, {"runs", std::move(masks)}};
  return j;
}

std::string data_uri(const std::string& jpeg) { return "data:image/jpeg;base64," + base64(jpeg); }

void warn_of(const PhotoFolder& folder, const std::vector<PagePhoto>& photos, StageContext& context) {
  for (const FolderNote& note : notes_of(folder)) context.warning(note.code, note.sentence());
  constexpr size_t kShown = 10;
  std::string text;
  size_t left_out = 0;
  for (const PagePhoto& p : photos) {
    if (p.failure.empty() || ++left_out > kShown) continue;
    text += fmt::format("\n         {}: {}", p.name, p.failure);
  }
  if (left_out > kShown) text += fmt::format("\n         and {} more", left_out - kShown);
  if (left_out > 0)
    context.warning("PHOTOS_LEFT_OUT", fmt::format("{} left out, which no run can use either:{}",
                                                   left_out == 1 ? "1 photo is" : fmt::format("{} photos are", left_out), text));
}

}  // namespace

void describe(Describer& d, MarkConfig& c) {
  d.option("photo_side", c.photo_side,
           "Longest side of the photos in the page, pixels; marks are in pixels of the photos as taken.")
      .range(kLeastSide, 8192);
  d.option("megapixels", c.megapixels,
           fmt::format("All photos of the page together: where there are many, each is smaller, down to {} pixels a side.",
                       kLeastSide))
      .range(1, 2000);
  d.option("command", c.command, "Command that the page shows for a run with the marks.");
}

void write_mark(const std::string& page, const MarkConfig& config, StageContext& context) {
  const fs::path input = context.input("photos");
  const PhotoFolder folder = find_photos(input);
  const auto given = context.optional_input("marks"), sfm = context.optional_input("sfm"),
             masks = context.optional_input("masks");
  const Json marks = given ? tree_of(read_yaml(given->string()).root) : Json();
  const size_t n = folder.photos.size();
  const std::vector<PagePhoto> photos = page_photos(folder, config.photo_side, config.megapixels, [&](size_t done) {
    context.progress({.fraction = double(done) / double(n), .text = fmt::format("{} / {} photos", done, n), .values = {}});
  });
  warn_of(folder, photos, context);
  const RunResults run = sfm ? read_run_results(*sfm, masks) : RunResults{};

  Json rows = Json::array(), left_out = Json::array(), pictures = Json::array(), small = Json::array(), classes = Json::array();
  Hasher shown;
  for (const PagePhoto& p : photos) {
    if (!p.failure.empty()) {
      left_out.push_back({{"name", p.name}, {"why", p.failure}});
      continue;
    }
    const auto known = run.photos.find(p.name);
    rows.push_back(photo_json(p, known == run.photos.end() ? nullptr : &known->second));
    pictures.push_back(data_uri(p.jpeg));
    small.push_back(data_uri(p.small));
    shown.add(p.name).add(p.digest);
  }
  if (rows.empty())
    throw Error(ErrorKind::Input, "none of the photos can be read",
                {.where = input.string(),
                 .why = fmt::format("{}: {}", photos[0].name, photos[0].failure),
                 .hint = "give the folder that holds the photos: JPEG, PNG, TIFF, EXR",
                 .code = "NO_PHOTOS"});
  for (MaskClass kind : kMaskClasses) classes.push_back(name(kind));
  const Json scene{{"format", 1},
                   {"id", shown.digest().short_hex()},
                   {"classes", std::move(classes)},
                   {"photos", std::move(rows)},
                   {"left_out", std::move(left_out)},
                   {"marks", marks},
                   {"marks_name", given ? Json(given->filename().string()) : Json()},
                   {"has_cameras", sfm.has_value()},
                   {"most_one_sided", kMostOneSided},
                   {"mask_sources", run.sources},
                   {"command", config.command}};
  const std::string text = page_of(page, {json_part("scene", scene), json_part("small", small), json_part("photos", pictures)});
  write_file(context.output() / kPage, text);
  context.metric("photos", double(small.size()));
  context.metric("size_bytes", double(text.size()));
  context.summary(fmt::format("{} photos, {:.1f} MB", small.size(), double(text.size()) / 1e6));
}

void run_mark(const MarkConfig& config, StageContext& context) {
  // Fails before any computation if the build has no page.
  write_mark(empty_page("mark", "to mark photos in"), config, context);
}

Stage mark_stage() {
  StageInfo info{
      .name = "mark",
      .version = 2,
      .summary = "one page that shows the photos, in which people draw what is glass and metal, and that saves marks.yaml",
      .inputs = {{.name = "photos", .artifact = false, .doc = "Folder of photos: JPEG, PNG, TIFF, EXR, HEIC, AVIF, raw."},
                 {.name = "marks", .artifact = false, .optional = true, .doc = "Marks to go on with: a YAML file."},
                 {.name = "sfm", .optional = true, .doc = "Cameras of a run: do the marked photos look from different sides?"},
                 {.name = "masks", .optional = true, .doc = "What the marks became in every photo of that run."}}};
  return make_stage<MarkConfig>(std::move(info), run_mark, [] {
    return std::map<std::string, std::string>{{"page", empty_page_digest("mark")}};
  });
}

}  // namespace vitrine
