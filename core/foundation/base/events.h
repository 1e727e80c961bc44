// The records of a run (events.jsonl, --log-format json): written by stages (stages/reporter.h) and by the pipeline
// (pipeline/report.h), one JSON object a line. configs/events.schema.json says which fields each type has. A change to it is a
// new version: configs/events.digests remembers the digest of every version's schema, and a test compares.
#pragma once

namespace vitrine {

inline constexpr int kEventsVersion = 2;  // 2: plan, checkpoint

}  // namespace vitrine
