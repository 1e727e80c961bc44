// The passes for AVX2: pass_*.h compiled with this file's flags (core/render/raster/CMakeLists.txt), in namespace vitrine::avx2.
#include "core/render/raster/cpu/raster_pass.h"
#include "core/render/raster/cpu/simd_avx2.h"
#include "core/render/raster/kernels/blend.h"
#include "core/render/raster/kernels/project.h"
#include "core/render/raster/kernels/shade.h"
#include "core/render/raster/kernels/splat_weight.h"

#define VITRINE_SIMD avx2
// Each file uses the ones before it.
// clang-format off
#include "core/render/raster/cpu/pass_math.h"
#include "core/render/raster/cpu/pass_pixels.h"
#include "core/render/raster/cpu/pass_lists.h"
#include "core/render/raster/cpu/pass_forward.h"
#include "core/render/raster/cpu/pass_backward.h"
#include "core/render/raster/cpu/pass_rows.h"
#include "core/render/raster/cpu/pass_project.h"
// clang-format on

namespace vitrine::cpu {

const PassTable& avx2_passes() { return avx2::pass_table("cpu-avx2"); }

}  // namespace vitrine::cpu
