#include "stages/normals/normals.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::normals_stage(), argc, argv); }
