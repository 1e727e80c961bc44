#include "stages/masks/masks.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::masks_stage(), argc, argv); }
