#include "tests/pipeline/stages/test_stages.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::test_stages::join_stage(), argc, argv); }
