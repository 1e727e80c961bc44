# Optimisation levels of sources, and merging of sources into larger translation units.

# vitrine_unhurried(target): code whose speed does not matter: tests, options, files, commands. Halves the build time; all checks of
# the sanitizers stay.
function(vitrine_unhurried target)
  set_target_properties(${target} PROPERTIES VITRINE_HEADERS unhurried)
  if(VITRINE_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  else()
    target_compile_options(${target} PRIVATE -O1)
  endif()
endfunction()

# vitrine_parsers(target): a library that mostly reads and writes files. The sanitized build compiles it without optimisation, which
# takes three fifths of the build time. Other builds compile it normally.
function(vitrine_parsers target)
  if(VITRINE_SANITIZE)
    vitrine_unhurried(${target})
  endif()
endfunction()

# vitrine_sources(target): required for every library and test.
# - The sanitized build compiles numerical code with -O1, but sources that read or write JSON without optimisation.
# - With VITRINE_MERGE=ON up to twelve sources are compiled as one file that includes them: headers are parsed and templates
#   instantiated once. Names at file level must therefore be unique per folder. (CMake's own unity build writes absolute paths into
#   its files, which defeats a compiler cache in another checkout, and omits every source with its own options.) A source with other
#   options than its target is compiled alone; so the sanitized build keeps sources that use JSON apart from the rest.
function(vitrine_sources target)
  cmake_language(EVAL CODE "cmake_language(DEFER CALL vitrine_arrange_sources ${target})")  # after the folder has set all its options
endfunction()

function(vitrine_arrange_sources target)
  get_target_property(sources ${target} SOURCES)
  get_target_property(way ${target} VITRINE_HEADERS)
  set(arranged)
  set(json)
  set(plain)
  foreach(source ${sources})
    get_filename_component(path ${source} ABSOLUTE)
    file(STRINGS ${path} uses_json REGEX "#include .*json.*\\.h" LIMIT_COUNT 1)
    get_source_file_property(options ${source} COMPILE_OPTIONS)
    get_source_file_property(definitions ${source} COMPILE_DEFINITIONS)
    if(NOT VITRINE_SANITIZE OR way)  # other header sets are compiled without optimisation anyway
      set(uses_json)
    elseif(uses_json)
      set_property(SOURCE ${source} APPEND PROPERTY COMPILE_OPTIONS -O0)
    endif()
    if(options OR definitions OR NOT VITRINE_MERGE)
      list(APPEND arranged ${source})
      if(options)
        set_property(SOURCE ${source} PROPERTY SKIP_PRECOMPILE_HEADERS ON)
      endif()
    elseif(uses_json)
      list(APPEND json ${path})
    else()
      list(APPEND plain ${path})
    endif()
  endforeach()
  foreach(kind json plain)
    list(LENGTH ${kind} left)
    math(EXPR files "(${left} + 11) / 12")
    set(first 0)
    while(left)
      math(EXPR here "(${left} + ${files} - 1) / ${files}")
      list(SUBLIST ${kind} ${first} ${here} together)
      math(EXPR first "${first} + ${here}")
      math(EXPR left "${left} - ${here}")
      math(EXPR files "${files} - 1")
      set(merged ${together})
      if(here GREATER 1)
        set(text)
        foreach(path ${together})
          file(RELATIVE_PATH path ${PROJECT_SOURCE_DIR} ${path})
          string(APPEND text "#include \"${path}\"\n")
        endforeach()
        set(merged ${CMAKE_CURRENT_BINARY_DIR}/${target}_${kind}_${first}.cpp)
        file(CONFIGURE OUTPUT ${merged} CONTENT "${text}" @ONLY)  # written only if changed
      endif()
      if(kind STREQUAL "json")
        add_dependencies(${target} vitrine_headers_unhurried)
        set(headers ${CMAKE_BINARY_DIR}/CMakeFiles/vitrine_headers_unhurried.dir/cmake_pch.hxx)  # compiled with the same options
        set_source_files_properties(${merged} PROPERTIES COMPILE_OPTIONS "-O0;-include;${headers}" OBJECT_DEPENDS ${headers}.gch
                                                         SKIP_PRECOMPILE_HEADERS ON)
      endif()
      list(APPEND arranged ${merged})
    endwhile()
  endforeach()
  set_target_properties(${target} PROPERTIES SOURCES "${arranged}")
  vitrine_share_headers(${target})
  if(VITRINE_MERGE)
    # In a merged file GCC takes anonymous namespaces of included sources for those of headers.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()

# Precompiled headers, used by nearly every source (about a tenth of the build time): with VITRINE_MERGE=ON compiled once per set of
# options and shared by its targets. Without VITRINE_MERGE the build verifies that every source includes the headers it needs.
set(VITRINE_SHARED_HEADERS <algorithm> <array> <cmath> <filesystem> <functional> <map> <optional> <span> <string> <vector>
                           <fmt/format.h> <nlohmann/json.hpp>)
if(VITRINE_MERGE)
  set(nothing ${CMAKE_BINARY_DIR}/nothing.cpp)
  file(CONFIGURE OUTPUT ${nothing} CONTENT "" @ONLY)
  set(ways plain unhurried)
  if(VITRINE_TESTS)
    list(APPEND ways tests)
  endif()
  foreach(way ${ways})
    add_library(vitrine_headers_${way} OBJECT ${nothing})
    target_precompile_headers(vitrine_headers_${way} PRIVATE ${VITRINE_SHARED_HEADERS})
    target_link_libraries(vitrine_headers_${way} PRIVATE fmt::fmt nlohmann_json::nlohmann_json)
    if(NOT way STREQUAL "plain")
      vitrine_unhurried(vitrine_headers_${way})
    endif()
  endforeach()
  if(VITRINE_TESTS)
    find_package(GTest REQUIRED)
    target_precompile_headers(vitrine_headers_tests PRIVATE <gtest/gtest.h>)
    target_link_libraries(vitrine_headers_tests PRIVATE GTest::gtest)
  endif()
endif()

function(vitrine_share_headers target)
  get_target_property(way ${target} VITRINE_HEADERS)
  get_target_property(libraries ${target} LINK_LIBRARIES)
  if(NOT VITRINE_MERGE OR libraries MATCHES "OpenMP")  # other options need another precompiled header
    return()
  endif()
  if(NOT way)
    set(way plain)
  endif()
  target_precompile_headers(${target} REUSE_FROM vitrine_headers_${way})
endfunction()
