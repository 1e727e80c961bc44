#include "stages/mark/mark.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::mark_stage(), argc, argv); }
