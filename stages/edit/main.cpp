#include "stages/edit/edit.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::edit_stage(), argc, argv); }
