// edit: changes to a finished scene, by mask class, box, marks in photos or component of the mesh: materials, and what is
// deleted. Started by `vitrine edit`; it stands beside the graph of `vitrine run`. The originals are only read: the same list
// gives the same scene again, and another list starts from the originals too.
//   reads   sfm (cameras), optimize, mesh; refine, decompose, masks when there are any; edits: a YAML file (edit_list.h)
//   writes  edited/{gaussians,optimize,mesh,decompose}: a folder that can be given in place of those artifacts;
//           edited/edits.yaml (the list), edited/report.json (what each edit selected; the mesh's components)
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct EditConfig {};
void describe(Describer& d, EditConfig& c);

void run_edit(const EditConfig& config, StageContext& context);
Stage edit_stage();

}  // namespace vitrine
