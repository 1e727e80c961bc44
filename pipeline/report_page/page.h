// Writes report.html: a single file without network requests that describes an output folder. Reads only that folder; sections
// with missing data are omitted.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "core/foundation/base/file.h"
#include "pipeline/report_page/figures.h"
#include "pipeline/report_page/regions.h"

namespace vitrine {

struct PageDesc {
  fs::path project;
  std::string typed = {};  // folder as typed in a command; empty: project
};

// Digest of everything the page depends on; stored in the page to detect outdated pages.
std::string page_state(const PageDesc& desc);
std::string report_page(const PageDesc& desc);
// Digest stored in a page; empty if vitrine did not write the file.
std::string state_of_page(const fs::path& file);

// HTML helpers. All text from files or users must pass through escaped(): a photo may be named <script>.

// Escapes text and attribute values in double quotes. Invalid UTF-8 and control characters become U+FFFD.
std::string escaped(std::string_view text);

// Sections of the page: HTML, or empty if the folder has no data for them.

// Shared input of the sections, read once.
struct Material {
  fs::path project;
  RunOutcome outcome;
  Figures figures;
  Verdict verdict;
  std::optional<ViewSet> views;   // nullopt if the sparse model cannot be read
  std::set<std::string> heldout;  // names of views
};

std::string opening_section(const Material& m);  // a large picture and the link to view.html
std::string verdict_section(const Material& m);
std::string figures_section(const Material& m);
std::string regions_section(const Material& m);
std::string compare_section(const Material& m);  // photo against rendered view, with a slider
std::string layers_section(const Material& m);   // layers of the picture
std::string surface_section(const Material& m);  // mesh and its normals
std::string relit_section(const Material& m);
std::string cameras_section(const Material& m);  // plan, elevation, photos without a pose
std::string cost_section(const Material& m);     // time and memory, warnings

// <section id><h2>title</h2>lead, body</section>; empty when the body is.
std::string section(std::string_view id, std::string_view title, std::string_view lead, const std::string& body);
std::string rating_badge(Rating rating);

}  // namespace vitrine
