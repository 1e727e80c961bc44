# How hard the compiler works on which sources, and which of them it reads together.

# vitrine_unhurried(target): code whose speed does not matter: tests themselves, options, files, commands. Half the time to build;
# under the sanitizers all checks stay.
function(vitrine_unhurried target)
  set_target_properties(${target} PROPERTIES VITRINE_HEADERS unhurried)
  if(VITRINE_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  else()
    target_compile_options(${target} PRIVATE -O1)
  endif()
endfunction()

# vitrine_parsers(target): a library that mostly reads and writes files. The sanitized build compiles it without optimisation, like
# what is unhurried: three fifths of the time to build. Other builds compile it like the rest.
function(vitrine_parsers target)
  if(VITRINE_SANITIZE)
    vitrine_unhurried(${target})
  endif()
endfunction()

# vitrine_sources(target): to be called for every library and test.
# - The sanitized build compiles numerical code with -O1, but those of the sources that read or write JSON without optimisation.
# - With VITRINE_MERGE=ON sources are compiled up to twelve at a time, as one file that includes them: headers are read and templates
#   instantiated once. So no two files of a folder may give a name at file level two meanings. (CMake's own unity build writes
#   absolute paths into its files, which a compiler cache does not find again in another checkout, and leaves out every source with
#   options of its own.) One with other options than its target is compiled alone; so the sanitized build keeps those that speak JSON
#   apart from the rest.
function(vitrine_sources target)
  cmake_language(EVAL CODE "cmake_language(DEFER CALL vitrine_arrange_sources ${target})")  # once the folder has set all its options
endfunction()

function(vitrine_arrange_sources target)
  get_target_property(sources ${target} SOURCES)
  get_target_property(way ${target} VITRINE_HEADERS)
  set(arranged)
  set(json)
  set(plain)
  foreach(source ${sources})
    get_filename_component(path ${source} ABSOLUTE)
    file(STRINGS ${path} speaks_json REGEX "#include .*json.*\\.h" LIMIT_COUNT 1)
    get_source_file_property(options ${source} COMPILE_OPTIONS)
    get_source_file_property(definitions ${source} COMPILE_DEFINITIONS)
    if(NOT VITRINE_SANITIZE OR way)  # those of another way are without optimisation anyway
      set(speaks_json)
    elseif(speaks_json)
      set_property(SOURCE ${source} APPEND PROPERTY COMPILE_OPTIONS -O0)
    endif()
    if(options OR definitions OR NOT VITRINE_MERGE)
      list(APPEND arranged ${source})
      if(options)
        set_property(SOURCE ${source} PROPERTY SKIP_PRECOMPILE_HEADERS ON)
      endif()
    elseif(speaks_json)
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
        file(CONFIGURE OUTPUT ${merged} CONTENT "${text}" @ONLY)  # touched only when it changes
      endif()
      if(kind STREQUAL "json")
        add_dependencies(${target} vitrine_headers_unhurried)
        set(headers ${CMAKE_BINARY_DIR}/CMakeFiles/vitrine_headers_unhurried.dir/cmake_pch.hxx)  # compiled the same way
        set_source_files_properties(${merged} PROPERTIES COMPILE_OPTIONS "-O0;-include;${headers}" OBJECT_DEPENDS ${headers}.gch
                                                         SKIP_PRECOMPILE_HEADERS ON)
      endif()
      list(APPEND arranged ${merged})
    endwhile()
  endforeach()
  set_target_properties(${target} PROPERTIES SOURCES "${arranged}")
  vitrine_share_headers(${target})
  if(VITRINE_MERGE)
    # What is local to an included file looks to GCC as if two files could see it differently.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()

# What nearly every source reads first, about a tenth of the time to build: with VITRINE_MERGE=ON compiled once for each way to
# compile, and read back by all targets of that way. Without it every source shows that it includes what it needs.
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
  if(NOT VITRINE_MERGE OR libraries MATCHES "OpenMP")  # -fopenmp is another way to compile
    return()
  endif()
  if(NOT way)
    set(way plain)
  endif()
  target_precompile_headers(${target} REUSE_FROM vitrine_headers_${way})
endfunction()
