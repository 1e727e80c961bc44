#include "stages/render/render.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::render_stage(), argc, argv); }
