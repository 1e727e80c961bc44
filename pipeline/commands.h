// Commands of `vitrine`. Each receives the arguments after its name and returns the exit code; it throws Error on failure.
#pragma once

#include <string>
#include <vector>

namespace vitrine {

using Words = std::vector<std::string>;

int run_command(const Words& words);
int render_command(const Words& words);
int relight_command(const Words& words);
int view_command(const Words& words);
int mark_command(const Words& words);
int export_command(const Words& words);
int inspect_command(const Words& words);
int report_command(const Words& words);
int edit_command(const Words& words);
int compose_command(const Words& words);
int ct_command(const Words& words);
int status_command(const Words& words);
int explain_command(const Words& words);
int doctor_command(const Words& words);
int config_command(const Words& words);
int cache_command(const Words& words);
int farm_command(const Words& words);

}  // namespace vitrine
