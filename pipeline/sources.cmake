# How hard the compiler works on which sources, and which of them it reads together.

# vitrine_unhurried(target): code whose speed does not matter: tests themselves, options, files, commands. Half the time to build;
# under the sanitizers all checks stay.
function(vitrine_unhurried target)
  if(VITRINE_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  else()
    target_compile_options(${target} PRIVATE -O1)
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
  set(arranged)
  set(json)
  set(plain)
  foreach(source ${sources})
    get_filename_component(path ${source} ABSOLUTE)
    file(STRINGS ${path} speaks_json REGEX "#include .*json.*\\.h" LIMIT_COUNT 1)
    get_source_file_property(options ${source} COMPILE_OPTIONS)
    get_source_file_property(definitions ${source} COMPILE_DEFINITIONS)
    if(NOT VITRINE_SANITIZE)
      set(speaks_json)
    elseif(speaks_json)
      set_property(SOURCE ${source} APPEND PROPERTY COMPILE_OPTIONS -O0)
    endif()
    if(options OR definitions OR NOT VITRINE_MERGE)
      list(APPEND arranged ${source})
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
      if(here EQUAL 1)
        list(APPEND arranged ${together})
        continue()
      endif()
      set(text)
      foreach(path ${together})
        file(RELATIVE_PATH path ${PROJECT_SOURCE_DIR} ${path})
        string(APPEND text "#include \"${path}\"\n")
      endforeach()
      set(merged ${CMAKE_CURRENT_BINARY_DIR}/${target}_${kind}_${first}.cpp)
      file(CONFIGURE OUTPUT ${merged} CONTENT "${text}" @ONLY)  # touched only when it changes
      if(kind STREQUAL "json")
        set_property(SOURCE ${merged} PROPERTY COMPILE_OPTIONS -O0)
      endif()
      list(APPEND arranged ${merged})
    endwhile()
  endforeach()
  set_target_properties(${target} PROPERTIES SOURCES "${arranged}")
  if(VITRINE_MERGE)
    # What is local to an included file looks to GCC as if two files could see it differently.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()
