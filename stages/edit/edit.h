// edit: changes materials of a finished scene or deletes parts of it, selected by mask class, object, box, marks in photos or
// mesh component. Started by `vitrine edit`; not part of the graph of `vitrine run`. The originals are only read: the same list
// gives the same scene, and another list starts from the originals again.
//   reads   sfm (cameras), optimize, mesh; refine, decompose, masks if they exist; edits: a YAML file (edit_list.h)
//   writes  edited/{gaussians,optimize,mesh,decompose}: a folder that can replace those artifacts;
//           edited/edits.yaml (the list), edited/report.json (selection of each edit; the mesh's components)
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct EditConfig {};
void describe(Describer& d, EditConfig& c);

void run_edit(const EditConfig& config, StageContext& context);
Stage edit_stage();

}  // namespace vitrine
