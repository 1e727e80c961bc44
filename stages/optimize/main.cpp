#include "stages/optimize/optimize.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::optimize_stage(), argc, argv); }
