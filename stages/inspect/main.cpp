#include "stages/inspect/inspect.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::inspect_stage(), argc, argv); }
