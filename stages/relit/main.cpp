#include "stages/relit/relit.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::relit_stage(), argc, argv); }
