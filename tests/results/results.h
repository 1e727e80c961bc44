// Measured runs as files, and the table of README.md that is made from them.
//
// A result is a JSON file: title, scene, preset, command, seeds, commit, machine (cpu, cores, threads), date, seconds,
// cpu_seconds, peak_memory_bytes, and figures, copied from eval/metrics.json under their names there ("heldout.psnr" in dB,
// "truth.normal_mae_deg" in degrees ...). A figure that the run did not measure is absent. Files are read in the order of their
// names. Errors: Error{Input} names the file and the missing entry.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vitrine {

// What the folder of a run does not hold.
struct RunLabel {
  std::string title;   // first column of the table
  std::string commit;  // of the sources that ran
  std::string cpu;     // as the processor names itself
  int cores = 0;
};

// The text of a result file, from config.resolved.yaml, run.json and eval/metrics.json of a finished run. Paths of the command
// are cut to `sample_data/...` or to their last name; the output folder is called `out`.
std::string recorded_run(const std::filesystem::path& run, const RunLabel& label);

// The Markdown table of all *.json of the folder, that of optics.json where it is there (optics_table.h), and one line for the
// machines of the former.
std::string results_table(const std::filesystem::path& folder);

// `page` with `table` between the two marks. Throws when it has not both, in this order.
std::string with_table(const std::string& page, const std::string& table);

}  // namespace vitrine
