# The page without a scene: page/ with its packages as one file, beside the program. Whoever has npm gets it; where it or its
# registry is missing, all else builds, and vitrine-view says what is missing.
find_program(NPM npm)
find_program(NODE node)
if(VITRINE_SANITIZE OR NOT TARGET vitrine-view)
  return()
endif()
file(GLOB page_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/page/*)
set(page ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/vitrine-view.html)
if(NPM AND NODE)
  add_custom_command(OUTPUT ${page}
    COMMAND ${CMAKE_COMMAND} -DNPM=${NPM} -DNODE=${NODE} -DFROM=${CMAKE_CURRENT_SOURCE_DIR}/page -DWORK=${CMAKE_BINARY_DIR}/page -DPAGE=${page}
            -P ${CMAKE_CURRENT_SOURCE_DIR}/bundle.cmake
    DEPENDS ${page_sources} bundle.cmake
    COMMENT "page of vitrine view" VERBATIM)
  add_custom_target(vitrine_page ALL DEPENDS ${page})
else()
  message(STATUS "npm or node is missing: `vitrine view` will have no page (Debian: apt-get install nodejs npm)")
endif()
