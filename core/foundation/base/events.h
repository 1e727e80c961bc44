// Event records of a run (events.jsonl, --log-format json), one JSON object per line, written by stages (stages/reporter.h) and
// the pipeline (pipeline/report.h). configs/events.schema.json lists the fields of each type. A schema change requires a new
// version: configs/events.digests contains the schema digest of every version, checked by a test.
#pragma once

namespace vitrine {

inline constexpr int kEventsVersion = 2;  // version 2 added plan, checkpoint

}  // namespace vitrine
