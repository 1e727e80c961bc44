// Tracer "reference": double, O(rays x surfels), one thread. For tests, benchmarks' checks and for bisecting a wrong picture.
#pragma once

#include <memory>

#include "core/trace/tracer.h"

namespace vitrine {

std::unique_ptr<Tracer> make_reference_tracer();

}  // namespace vitrine
