#include "stages/optimize/memory.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::optimize_stage(), argc, argv, vitrine::optimize_fit()); }
