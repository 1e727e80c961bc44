// Early checks of the user's input files: a wrong path or a mistake in a file of marks is reported at once, not by a stage an
// hour later.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/file.h"
#include "core/intake/masks/marks_check.h"
#include "core/intake/photos/photo_files.h"
#include "pipeline/plan.h"

namespace vitrine {

// Photos of a folder with all names that users and stages use for them. Empty if the folder is missing or has no photos; ingest
// reports that.
class PhotoNames {
 public:
  explicit PhotoNames(const fs::path& photos);

  bool empty() const { return files_.empty(); }
  std::vector<std::string> all() const;  // names of the ingest stage
  const std::string& name(size_t photo) const { return files_[photo].name; }
  // Looks up the ingest name: relative path; .exr becomes .png; of two names that differ only in the extension, the second one
  // keeps it in its stem.
  std::optional<size_t> find(const std::string& name) const;
  bool has(const std::string& name) const { return find(name).has_value(); }
  // Also matches a part of the name, as in a file of marks (core/foundation/config/photo_name_finder.h). nullopt: none or several
  // match, which is reported.
  std::optional<size_t> find_by_part(const YamlNode& name, YamlReader& in) const;
  // Upright, before any reduction; nullopt for an unreadable photo.
  std::optional<PhotoPixels> pixels(size_t photo) const;
  // The photo with the most similar name; empty if none is similar.
  std::string nearest(const std::string& name) const;

 private:
  std::vector<std::string> sources() const;
  std::vector<PhotoFile> files_;
};

// Checks that results do not overwrite inputs, also through links. Throws Error{Usage} if the output folder lies inside an input
// folder, or an input lies where results of the output folder go.
void check_inputs_apart(const fs::path& project, const Graph& graph, const Settings& settings);

// Checks a file of marks against the photos (core/intake/masks/marks_check.h). Throws Error{Usage}.
void check_marks(const fs::path& marks, const fs::path& photos);

// Checks the inputs given in this command or read by its chosen stages. Throws Error{Input} for a missing input, or masks in
// unknown class folders or of other photos; Error{Usage} for a file of marks with mistakes.
void check_given_inputs(const Planner& planner, const Settings& settings);

// "preset preview -> standard, masks marks.yaml -> none"; empty without differences. For two presets only their names and the
// inputs are compared.
std::string changed_settings(const Settings& before, const Settings& now);

}  // namespace vitrine
