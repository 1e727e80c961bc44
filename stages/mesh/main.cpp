#include "stages/mesh/mesh.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::mesh_stage(), argc, argv); }
