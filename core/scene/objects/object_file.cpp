// objects.json: {"format": 1, "frame": "scene", "objects": [{"id", "name", "role", "trust", "evidence", "shapes": [...]}]};
// "shapes" has entries of core/scene/shape/shape_file.h without role (the object's role applies); "parent" is an index within
// the object.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/config/json_file.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/objects/object_set.h"
#include "core/scene/shape/shape_file.h"

namespace vitrine {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr size_t kMostObjects = 65534;  // 16-bit labels, two values are reserved
constexpr std::array<std::string_view, 4> kShapeRoles{"mirror", "sheet", "coat", "solid"};  // [ShapeRole], names of shape_file.h

template <class Enum, size_t N>
Enum word_of(const JsonAt& object, const char* key, std::optional<Enum> (*parse)(std::string_view)) {
  const JsonAt value = object.at(key);
  const std::string word = value.text();
  if (const auto found = parse(word)) return *found;
  std::vector<std::string_view> known;
  for (size_t i = 0; i < N; ++i) known.push_back(name(static_cast<Enum>(i)));
  value.fail(fmt::format("there is no {} \"{}\"; there are {}", key, word, fmt::join(known, ", ")));
}

Object read_object(const JsonAt& at) {
  const double id = at.at("id").number();
  if (!(id >= 1 && id <= double(kMostObjects)) || id != std::floor(id))
    at.at("id").fail(fmt::format("an id is a whole number from 1 to {}", kMostObjects));
  Object out{.id = static_cast<uint16_t>(id),
             .name = at.at("name").text(),
             .role = word_of<ObjectRole, kObjectRoles>(at, "role", object_role),
             .trust = at.has("trust") ? word_of<ObjectTrust, kObjectTrusts>(at, "trust", object_trust) : ObjectTrust::Given};
  if (out.name.empty()) at.at("name").fail("a name has at least one letter");
  if (!at.has("evidence")) return out;
  const JsonAt evidence = at.at("evidence");
  const auto number = [&](const char* key) {
    return evidence.has(key) ? std::optional(evidence.at(key).number()) : std::nullopt;
  };
  out.evidence = {.views = size_t(std::max(0.0, number("views").value_or(0))),
                  .inside = number("inside_masks"),
                  .covered = number("masks_covered"),
                  .view_dependence = number("view_dependence"),
                  .straight = number("like_straight_rays"),
                  .bent = number("like_bent_rays")};
  return out;
}

// Shapes of all objects as one list of core/scene/shape/shape_file.h, with their places in the document.
struct ShapeList {
  nlohmann::json entries = nlohmann::json::array();
  std::vector<std::string> places;
  std::vector<uint16_t> objects;
};

void add_shapes(const JsonAt& at, const Object& object, size_t index, ShapeList& list) {
  if (!at.has("shapes")) return;
  const JsonAt shapes = at.at("shapes");
  const size_t first = list.places.size(), count = shapes.list("a list of shapes").size();
  for (size_t k = 0; k < count; ++k) {
    nlohmann::json entry = shapes[k].value();
    const std::string place = fmt::format("/objects/{}/shapes/{}", index, k);
    if (!entry.is_object()) throw JsonMistake(place, "expected a shape");
    entry["role"] = kShapeRoles[static_cast<size_t>(shape_role(object.role))];
    if (entry.contains("parent")) {
      if (!entry["parent"].is_number_integer() || entry["parent"] < 0 || entry["parent"] >= k)
        throw JsonMistake(place, "the parent of a shape is the number of one before it in the same object, from 0");
      entry["parent"] = entry["parent"].get<size_t>() + first;
    }
    list.entries.push_back(std::move(entry));
    list.places.push_back(place);
    list.objects.push_back(object.id);
  }
}

ObjectSet read_document(const nlohmann::json& document, const fs::path& folder) {
  const JsonAt root(document);
  ObjectSet set;
  ShapeList list;
  const JsonAt objects = root.at("objects");
  std::set<std::string> names;
  for (size_t i = 0, count = objects.list("a list of objects").size(); i < count; ++i) {
    const JsonAt at = objects[i];
    Object object = read_object(at);
    if (std::ranges::any_of(set.objects, [&](const Object& o) { return o.id == object.id; }))
      at.at("id").fail(fmt::format("two objects have the id {}", object.id));
    if (!names.insert(object.name).second) at.at("name").fail(fmt::format("two objects are called \"{}\"", object.name));
    add_shapes(at, object, i, list);
    set.objects.push_back(std::move(object));
  }
  try {
    set.shapes = read_shapes(list.entries, [&](size_t entry) {
      return read_mesh_ply(path_inside(folder, list.entries[entry].at("mesh").get<std::string>()));
    });
  } catch (const ShapeMistake& e) {
    throw JsonMistake(list.places[std::min(e.entry, list.places.size() - 1)], e.what());
  }
  for (size_t i = 0; i < list.objects.size(); ++i) set.shapes.entries[i].object = list.objects[i];
  std::ranges::sort(set.objects, {}, &Object::id);
  return set;
}

}  // namespace

ObjectSet read_objects_file(const fs::path& given) {
  std::error_code ec;
  const fs::path file = fs::is_directory(given, ec) ? given / "objects.json" : given;
  ObjectSet set;
  read_json_file(file, "table of objects", [&](const nlohmann::json& j) { set = read_document(j, file.parent_path()); });
  return set;
}

ObjectSet read_objects(const std::optional<fs::path>& artifact) {
  std::error_code ec;
  if (!artifact || !fs::exists(*artifact / "objects/objects.json", ec)) return {};
  return read_objects_file(*artifact / "objects/objects.json");
}

void write_objects(const fs::path& folder, const ObjectSet& set) {
  Json shapes = write_shapes(set.shapes, folder);
  Json objects = Json::array();
  for (const Object& o : set.objects) {
    Json row{{"id", o.id}, {"name", o.name}, {"role", name(o.role)}, {"trust", name(o.trust)}};
    Json& evidence = row["evidence"] = {{"views", o.evidence.views}};
    if (o.evidence.inside) evidence["inside_masks"] = *o.evidence.inside;
    if (o.evidence.covered) evidence["masks_covered"] = *o.evidence.covered;
    if (o.evidence.view_dependence) evidence["view_dependence"] = *o.evidence.view_dependence;
    if (o.evidence.straight) evidence["like_straight_rays"] = *o.evidence.straight;
    if (o.evidence.bent) evidence["like_bent_rays"] = *o.evidence.bent;
    Json& own = row["shapes"] = Json::array();
    std::vector<size_t> numbers(set.shapes.entries.size());  // index within the object
    for (size_t i = 0; i < set.shapes.entries.size(); ++i) {
      if (set.shapes.entries[i].object != o.id) continue;
      numbers[i] = own.size();
      Json entry = std::move(shapes[i]);
      entry.erase("role"), entry.erase("object");
      if (set.shapes.entries[i].parent >= 0) entry["parent"] = numbers[size_t(set.shapes.entries[i].parent)];
      own.push_back(std::move(entry));
    }
    objects.push_back(std::move(row));
  }
  write_file(folder / "objects.json", readable(Json{{"format", 1}, {"frame", "scene"}, {"objects", std::move(objects)}}));
}

}  // namespace vitrine
