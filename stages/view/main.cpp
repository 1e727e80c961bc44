#include "stages/view/view.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::view_stage(), argc, argv); }
