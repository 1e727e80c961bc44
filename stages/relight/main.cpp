#include "stages/relight/relight.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::relight_stage(), argc, argv); }
