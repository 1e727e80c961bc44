#include <cstdio>
#include <string_view>

#include "stages/export/export.h"

int main(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--list") {
    std::fputs(vitrine::format_table().c_str(), stdout);
    return 0;
  }
  return vitrine::stage_main(vitrine::export_stage(), argc, argv);
}
