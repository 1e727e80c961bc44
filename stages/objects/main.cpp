#include "stages/objects/objects.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::objects_stage(), argc, argv); }
