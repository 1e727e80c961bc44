#include "stages/decompose/mesh_verdicts.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/json.h"
#include "core/base/json_cause.h"

namespace vitrine {

std::vector<MeshVerdict> mesh_verdicts(const std::filesystem::path& report) {
  std::vector<MeshVerdict> verdicts;
  std::error_code ec;
  if (!std::filesystem::exists(report, ec)) return verdicts;
  try {
    const auto json = nlohmann::json::parse(read_file(report));
    if (!json.contains("mirrors") || !json.at("mirrors").is_array()) return verdicts;  // mesh 3 had one box for all
    for (const auto& part : json.at("mirrors")) {
      MeshVerdict& v = verdicts.emplace_back();
      v.metal = part.at("kind") == "metal";
      for (size_t c = 0; c < 3; ++c) v.bounds.low[c] = part.at("low").at(c), v.bounds.high[c] = part.at("high").at(c);
    }
  } catch (const nlohmann::json::exception& e) {
    throw Error(ErrorKind::Input, "the report of the mesh is unusable",
                {.where = report.string(), .why = cause_of(e), .hint = "run the mesh stage again", .code = "BAD_MESH_REPORT"});
  }
  return verdicts;
}

const MeshVerdict* verdict_on(int number, const TriMesh& mesh, const std::vector<int>& of_face,
                              const std::vector<MeshVerdict>& verdicts) {
  std::vector<size_t> inside(verdicts.size(), 0);
  size_t faces = 0;
  for (size_t f = 0; f < of_face.size(); ++f) {
    if (of_face[f] != number) continue;
    ++faces;
    const auto& v = mesh.faces[f];
    const Vec3f centre = (mesh.positions[v[0]] + mesh.positions[v[1]] + mesh.positions[v[2]]) / 3.f;
    for (size_t i = 0; i < verdicts.size(); ++i) inside[i] += verdicts[i].bounds.contains(centre);
  }
  const auto most = std::ranges::max_element(inside);
  return most == inside.end() || 2 * *most <= faces ? nullptr : &verdicts[size_t(most - inside.begin())];
}

}  // namespace vitrine
