# Kernels for a GPU: compiled where there is nvcc, which the packages of pipeline/setup.sh lack, and left out elsewhere. No machine needs a
# card to build them. -DVITRINE_NVCC= leaves them out, too.
find_program(VITRINE_NVCC nvcc HINTS ENV CUDA_PATH PATH_SUFFIXES bin PATHS /usr/local/cuda
             DOC "CUDA compiler that knows C++20; empty: no kernels for a GPU")
# A100, H100, and what newer cards translate when the program starts. No fused multiply-add but where the source writes one: the bytes must be those of the CPU. Kernels call functions
# that are constexpr (mix64).
set(VITRINE_NVCC_OPTIONS -std=c++20 -O3 -fmad=false --expt-relaxed-constexpr -Werror cross-execution-space-call -gencode arch=compute_80,code=sm_80 -gencode arch=compute_90,code=[sm_90,compute_90]
                         -Xcompiler=-O2,-march=${VITRINE_MARCH},-ffp-contract=off)

# An nvcc that knows no C++20, or not the host compiler, is left alone: the build is then as without one.
if(VITRINE_NVCC AND NOT VITRINE_NVCC_TRIED STREQUAL VITRINE_NVCC)
  file(WRITE ${CMAKE_BINARY_DIR}/device/trial.cu "#include <cmath>\n__global__ void trial(float* x) { *x = std::sqrt(*x); }\n")
  execute_process(COMMAND ${VITRINE_NVCC} ${VITRINE_NVCC_OPTIONS} -c ${CMAKE_BINARY_DIR}/device/trial.cu -o ${CMAKE_BINARY_DIR}/device/trial.o
                  RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE reason)
  if(failed)
    message(STATUS "no kernels for a GPU: ${VITRINE_NVCC} compiles no C++20:\n${reason}")
    set(VITRINE_NVCC "" CACHE FILEPATH "" FORCE)
  endif()
  set(VITRINE_NVCC_TRIED "${VITRINE_NVCC}" CACHE INTERNAL "the nvcc that compiled the trial")
endif()

# vitrine_device_objects(target objects SOURCES x.cu ...): a custom target with one object file for each source, and in `objects`
# their paths. build/device/x.usage lists registers and memory of every kernel in x.cu.
function(vitrine_device_objects target objects)
  cmake_parse_arguments(D "" "" "SOURCES" ${ARGN})
  set(built)
  foreach(source ${D_SOURCES})
    get_filename_component(path ${source} ABSOLUTE)
    get_filename_component(name ${source} NAME_WE)
    set(object ${CMAKE_BINARY_DIR}/device/${name}.o)
    set(usage ${CMAKE_BINARY_DIR}/device/${name}.usage)
    list(JOIN VITRINE_NVCC_OPTIONS " " options)
    add_custom_command(OUTPUT ${object} BYPRODUCTS ${usage} DEPENDS ${path} DEPFILE ${object}.d
      COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/device
      COMMAND sh -c "'${VITRINE_NVCC}' ${options} -Xptxas -v -I'${PROJECT_SOURCE_DIR}' -MD -MF '${object}.d' -MT '${object}' -c '${path}' -o '${object}' 2> '${usage}' || { cat '${usage}' >&2; exit 1; }"
      VERBATIM COMMENT "Building CUDA object device/${name}.o")
    list(APPEND built ${object})
  endforeach()
  add_custom_target(${target} DEPENDS ${built})
  set(${objects} ${built} PARENT_SCOPE)
endfunction()
