// Which faces of the mesh are one polished thing: those that hang together, but those on each known shape of training apart.
// Silhouettes of things that touch are one hull; what training knows tells them apart.
#pragma once

#include <vector>

#include "core/mesh/tri_mesh.h"
#include "core/shape/shape_set.h"
#include "stages/decompose/mesh_verdicts.h"

namespace vitrine {

struct PolishedFaces {
  std::vector<int> thing;  // [face] or -1
  std::vector<int> known;  // [thing] entry of the shapes, or -1
};

inline bool is_mirror(const ShapeSet& shapes, int entry) { return shapes.entries[size_t(entry)].role == ShapeRole::Mirror; }

// Things are numbered in the order of the faces. What is left beside a known mirror, metal by the verdict of the mesh stage (an
// appendage), belongs to the mirror that it hangs together with. `polished`: [face]; `shapes`: of training, or nullptr.
PolishedFaces polished_faces(const TriMesh& mesh, const std::vector<uint8_t>& polished, const ShapeSet* shapes,
                             const std::vector<MeshVerdict>& verdicts);

}  // namespace vitrine
