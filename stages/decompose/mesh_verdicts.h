// What the mesh stage has decided of polished things: where its report says metal, the mesh has the shape of silhouettes, and
// where it says glaze, the shape that surfels learnt. Whoever asks again follows: a metal with a glaze's normals mirrors the
// wrong things.
#pragma once

#include <filesystem>
#include <vector>

#include "core/math/rigid.h"
#include "core/mesh/tri_mesh.h"

namespace vitrine {

struct MeshVerdict {
  Bounds3 bounds;
  bool metal = false;
};

// `mirrors` of mesh/report.json; none: the stage was not asked, or found nothing. Throws Error{Input} for a damaged report.
std::vector<MeshVerdict> mesh_verdicts(const std::filesystem::path& report);

// The verdict that most faces of thing `number` (of_face[f] == number) lie in; nullptr when less than half of them do in any.
const MeshVerdict* verdict_on(int number, const TriMesh& mesh, const std::vector<int>& of_face,
                              const std::vector<MeshVerdict>& verdicts);

}  // namespace vitrine
