// Sections of the page: HTML, or empty if the folder has no data for them.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "pipeline/report_page/figures.h"
#include "pipeline/report_page/regions.h"
#include "pipeline/report_page/verdict.h"

namespace vitrine {

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
