#include "stages/decompose/polished_faces.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/math/disjoint_sets.h"

namespace vitrine {

namespace {

constexpr double kOnShape = 2;  // tolerances between a face and the shape that it lies on

// The known mirrors and coats, and where faces on them can be at all.
class KnownPolished {
 public:
  explicit KnownPolished(const ShapeSet* shapes) : shapes_(shapes) {
    if (shapes == nullptr) return;
    for (const ShapeSet::Entry& e : shapes->entries)
      reach_.push_back(e.role == ShapeRole::Sheet ? Bounds3{} : bounds(e.shape, kOnShape * e.tolerance));
  }
  // The entry at a place, -1: none. Appendages are of one thing with what they stand out of.
  int at(const Vec3d& p) const {
    int best = -1;
    double least = kOnShape;
    for (size_t i = 0; i < reach_.size(); ++i) {
      if (!reach_[i].contains(p)) continue;
      const ShapeSet::Entry& e = shapes_->entries[i];
      const double off = length(nearest(e.shape, p).position - p) / e.tolerance;
      if (off < least) least = off, best = int(i);
    }
    return best < 0 ? -1 : int(shapes_->root(uint32_t(best)));
  }

 private:
  const ShapeSet* shapes_;
  std::vector<Bounds3> reach_;  // [entry]; none: a sheet
};

}  // namespace

PolishedFaces polished_faces(const TriMesh& mesh, const std::vector<uint8_t>& polished, const ShapeSet* shapes,
                             const std::vector<MeshVerdict>& verdicts) {
  DisjointSets corners(mesh.positions.size());
  for (size_t f = 0; f < polished.size(); ++f)
    for (size_t i = 1; i < 3 && polished[f]; ++i) corners.unite(mesh.faces[f][i], mesh.faces[f][0]);
  const KnownPolished known_shapes(shapes);
  PolishedFaces out{std::vector<int>(polished.size(), -1), {}};
  std::map<std::pair<int, uint32_t>, int> numbers;    // [known shape, or -1 and group]
  std::map<uint32_t, std::map<int, size_t>> mirrors;  // [group][thing] faces
  std::vector<uint32_t> group;                        // [thing]
  for (size_t f = 0; f < polished.size(); ++f) {
    if (!polished[f]) continue;
    const auto& v = mesh.faces[f];
    const uint32_t at = corners.representative(v[0]);
    const int known = known_shapes.at(cast<double>(mesh.positions[v[0]] + mesh.positions[v[1]] + mesh.positions[v[2]]) / 3.0);
    const auto [number, added] = numbers.try_emplace({known, known < 0 ? at : 0}, int(out.known.size()));
    if (added) out.known.push_back(known), group.push_back(at);
    out.thing[f] = number->second;
    if (known >= 0 && is_mirror(*shapes, known)) ++mirrors[at][number->second];
  }
  std::vector<int> belongs(out.known.size());
  for (size_t t = 0; t < belongs.size(); ++t) {
    belongs[t] = int(t);
    const auto beside = mirrors.find(group[t]);
    if (out.known[t] >= 0 || beside == mirrors.end()) continue;
    const MeshVerdict* verdict = verdict_on(int(t), mesh, out.thing, verdicts);
    if (verdict != nullptr && verdict->metal)
      belongs[t] = std::ranges::max_element(beside->second, {}, [](const auto& m) { return m.second; })->first;
  }
  for (int& t : out.thing)
    if (t >= 0) t = belongs[size_t(t)];
  return out;
}

}  // namespace vitrine
