// manifest.json: the content of a finished artifact. Its presence marks the folder as committed.
//   key             = digest of the terms: stage, version, every option that affects the result, content digest of every input,
//                     fingerprints of tools. Terms are stored as text, so that a later plan can report which one changed.
//   content_digest  = digest over (path, digest) of the output files. Runs that write the same bytes have equal content digests,
//                     whatever the clock, folder or machine. Keys of downstream stages use it.
// Timings are in timing.json in the same folder, which no digest covers.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

using KeyTerms = std::map<std::string, std::string>;  // "stage", "version", "option.voxel", "input.sfm", "tool.colmap"

std::string key_of(const KeyTerms& terms);  // 32 hex digits

struct OutputFile {
  std::string path;  // relative, '/' between parts
  size_t bytes = 0;
  std::string digest;
};

struct OptionEcho {
  std::string path, value, origin;
};

struct ManifestWarning {
  std::string code, text;
};

struct Manifest {
  std::string stage;
  int version = 1;
  std::string tool_version;
  std::string key;
  std::string content_digest;
  KeyTerms terms;
  std::vector<OptionEcho> options;  // all of them, including those outside the key
  std::vector<OutputFile> outputs;  // sorted by path
  std::map<std::string, double> metrics;
  std::vector<ManifestWarning> warnings;
  std::string summary;  // one line for the console
};

std::string content_digest_of(const std::vector<OutputFile>& outputs);
std::string to_json(const Manifest& manifest);
// Throws Error{Input} with `where` when the text is not a manifest.
Manifest manifest_from_json(std::string_view text, const std::string& where);

// Differences between two sets of terms as text: "option voxel 0.004 -> 0.002", "input sfm changed", "version 2 -> 3".
std::vector<std::string> changed_terms(const KeyTerms& before, const KeyTerms& now);

}  // namespace vitrine
