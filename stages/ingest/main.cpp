#include "stages/ingest/ingest.h"

int main(int argc, char** argv) { return vitrine::stage_main(vitrine::ingest_stage(), argc, argv); }
