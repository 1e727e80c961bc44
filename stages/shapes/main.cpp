#include "stages/shapes/shapes.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::shapes_stage(), argc, argv); }
