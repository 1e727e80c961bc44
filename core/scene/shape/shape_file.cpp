#include "core/scene/shape/shape_file.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/foundation/base/json.h"
#include "core/scene/mesh/mesh_io.h"

namespace vitrine {

namespace {

constexpr std::array<const char*, 4> kRoles{"mirror", "sheet", "coat", "solid"};  // [ShapeRole]

std::filesystem::path mesh_path(const std::filesystem::path& folder, size_t entry) {
  return folder / fmt::format("shape_{}.ply", entry);
}

ShapeSet::Entry read_entry(const nlohmann::json& json, const ShapeSet& before, const MeshSource& mesh) {
  const size_t index = before.entries.size();
  const auto unusable = [&](const std::string& why) { return ShapeMistake(index, why); };
  const ShapeKind* kind = find_shape_kind(json.at("kind").get<std::string>());
  if (!kind) throw unusable("there is no such kind");
  const auto word = json.at("role").get<std::string>();
  const auto role = std::ranges::find(kRoles, word);
  if (role == kRoles.end())
    throw unusable(fmt::format("there is no role \"{}\"; the roles are {}", word, fmt::join(kRoles, ", ")));
  const std::optional<Shape> shape = kind->read(json, json.contains("mesh") ? mesh(index) : TriMesh{});
  if (!shape) throw unusable(fmt::format("its numbers are no {}", kind->name));
  ShapeSet::Entry entry{*shape,
                        static_cast<ShapeRole>(role - kRoles.begin()),
                        json.at("tolerance").get<double>(),
                        json.value("parent", -1),
                        json.value("clear", std::vector<uint8_t>()),
                        json.value("exact", true),
                        json.value("object", uint16_t(0)),
                        json.value("layered", 1.0)};
  if (!(entry.layered >= 0 && entry.layered <= 1)) throw unusable("its share of the layers is not between 0 and 1");
  if (!(entry.tolerance > 0) || !std::isfinite(entry.tolerance)) throw unusable("its tolerance is not positive");
  // Parents precede their appendages: no cycles.
  if (entry.parent < -1 || entry.parent >= static_cast<int>(index)) throw unusable("its parent is unknown");
  if (entry.parent >= 0 && before.entries[static_cast<size_t>(entry.parent)].role != entry.role)
    throw unusable("its parent has another role");
  if (!entry.clear.empty() && entry.clear.size() != facets(entry.shape).size())
    throw unusable("its clear facets are not its facets");
  return entry;
}

}  // namespace

nlohmann::ordered_json write_shapes(const ShapeSet& set, const MeshSink& keep_mesh) {
  auto out = nlohmann::ordered_json::array();
  for (size_t i = 0; i < set.entries.size(); ++i) {
    const ShapeSet::Entry& entry = set.entries[i];
    const ShapeKind& kind = kind_of(entry.shape);
    nlohmann::ordered_json json{
        {"kind", kind.name}, {"role", kRoles[static_cast<size_t>(entry.role)]}, {"tolerance", entry.tolerance}};
    if (entry.parent >= 0) json["parent"] = entry.parent;
    if (!entry.clear.empty()) json["clear"] = entry.clear;
    if (!entry.exact) json["exact"] = false;
    if (entry.object != 0) json["object"] = entry.object;
    if (entry.layered != 1) json["layered"] = entry.layered;
    if (const TriMesh* mesh = kind.mesh(entry.shape)) {
      json["mesh"] = mesh_path({}, i).string();
      keep_mesh(i, *mesh);
    }
    json.update(kind.write(entry.shape));
    out.push_back(std::move(json));
  }
  return out;
}

nlohmann::ordered_json write_shapes(const ShapeSet& set, const std::filesystem::path& folder) {
  return write_shapes(set, [&](size_t entry, const TriMesh& mesh) { write_mesh_ply(mesh_path(folder, entry), mesh); });
}

ShapeMistake::ShapeMistake(size_t number, const std::string& why)
    : std::domain_error(fmt::format("shape {}: {}", number, why)), entry(number) {}

ShapeSet read_shapes(const nlohmann::json& json, const MeshSource& mesh) {
  ShapeSet set;
  for (const nlohmann::json& entry : json) {
    try {
      set.entries.push_back(read_entry(entry, set, mesh));
    } catch (const nlohmann::json::exception& e) {
      throw ShapeMistake(set.entries.size(), cause_of(e));
    }
  }
  return set;
}

ShapeSet read_shapes(const nlohmann::json& json, const std::filesystem::path& folder) {
  return read_shapes(json, [&](size_t entry) { return read_mesh_ply(mesh_path(folder, entry)); });
}

}  // namespace vitrine
