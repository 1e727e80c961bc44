#include "stages/decompose/decompose.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::decompose_stage(), argc, argv); }
