#include "stages/refine/refine.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::refine_stage(), argc, argv); }
