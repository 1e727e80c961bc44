#include "stages/export/export.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::export_stage(), argc, argv); }
