#include "stages/sfm/sfm.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::sfm_stage(), argc, argv); }
