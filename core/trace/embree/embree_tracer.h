// Tracer "embree": single precision, threads, hit lists for the reverse. Same bytes for any number of threads (README 6, 7).
#pragma once

#include <memory>

#include "core/trace/tracer.h"

namespace vitrine {

std::unique_ptr<Tracer> make_embree_tracer();

}  // namespace vitrine
