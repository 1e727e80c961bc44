// What a user hands in beside the photos, looked at before anything is computed: a mistyped path or a slip in a file of marks is
// told at once, not by the stage that reads it an hour later.
#pragma once

#include <string>
#include <vector>

#include "core/base/file.h"
#include "core/photo/photo_files.h"
#include "pipeline/plan.h"

namespace vitrine {

// The photos of a folder, with all names that users and stages have for them. Nothing where the folder is missing or holds none:
// ingest says so.
class PhotoNames {
 public:
  explicit PhotoNames(const fs::path& photos);

  bool empty() const { return files_.empty(); }
  std::vector<std::string> all() const;  // as the ingest stage calls them
  // As the ingest stage calls them: with their folders; an .exr becomes a .png; of two that differ by their extension alone the
  // second keeps it in its stem.
  bool has(const std::string& name) const;
  // Also by a part of it, as in a file of marks (core/config/photo_name_finder.h).
  bool has_by_part(const std::string& name) const;
  // The photo that is called most like it; empty if none is.
  std::string nearest(const std::string& name) const;

 private:
  std::vector<PhotoFile> files_;
};

// Results are never written into what they are made from, nor over it, by whatever links it is reached. Error{Usage}: the output
// folder lies in a folder that is given; or one that is given lies where results of the output folder go.
void check_inputs_apart(const fs::path& project, const Graph& graph, const Settings& settings);

// Of what this command gives or its chosen stages read. Error{Input}: it does not exist. Error{Usage}: a file of marks that
// cannot be read as YAML, marks a photo that is not there, or has an outline that is none. Error{Input}: masks in folders that
// are no classes, or of other photos.
void check_given_inputs(const Planner& planner, const Settings& settings);

// "preset preview -> standard, masks marks.yaml -> none"; empty where nothing differs. Of two presets only their names and the
// inputs.
std::string changed_settings(const Settings& before, const Settings& now);

}  // namespace vitrine
