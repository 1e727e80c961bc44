#include "stages/evaluate/evaluate.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::evaluate_stage(), argc, argv); }
