# Pages of HTML that programs fill with data: <stage>/page/ and what all pages share (page/), with the packages they use, as one file
# beside the program (vitrine-<stage>.html). Whoever has npm gets them; where it or its registry is missing, all else builds, and
# the program says what is missing.
find_program(NPM npm)
find_program(NODE node)
set(VITRINE_PAGES_HOME ${CMAKE_CURRENT_LIST_DIR} CACHE INTERNAL "")
set(VITRINE_PAGES_WORK ${CMAKE_BINARY_DIR}/page CACHE INTERNAL "")

# vitrine_npm_packages(target FROM folder WORK folder WITHOUT sentence): the target installs what FROM/package-lock.json names into
# WORK/node_modules. Where that fails the build says WITHOUT and goes on.
function(vitrine_npm_packages target)
  cmake_parse_arguments(P "" "FROM;WORK;WITHOUT" "" ${ARGN})
  set(packages ${P_WORK}/node_modules/.package-lock.json)  # npm writes it when all packages are there
  add_custom_command(OUTPUT ${packages}
    COMMAND ${CMAKE_COMMAND} -DNPM=${NPM} -DFROM=${P_FROM} -DWORK=${P_WORK} -DWITHOUT=${P_WITHOUT} -P ${VITRINE_PAGES_HOME}/install.cmake
    DEPENDS ${P_FROM}/package.json ${P_FROM}/package-lock.json ${VITRINE_PAGES_HOME}/install.cmake
    COMMENT "npm packages of ${P_FROM}" VERBATIM)
  add_custom_target(${target} DEPENDS ${packages})
endfunction()

if(NOT VITRINE_SANITIZE AND NPM AND NODE)
  vitrine_npm_packages(vitrine_page_packages FROM ${VITRINE_PAGES_HOME} WORK ${VITRINE_PAGES_WORK}
                       WITHOUT "`vitrine view`, `vitrine mark` and `vitrine ct` have no page")
  set(VITRINE_PAGES_PACKAGES ${VITRINE_PAGES_WORK}/node_modules/.package-lock.json CACHE INTERNAL "")
  add_custom_target(vitrine_page)  # all pages
elseif(NOT VITRINE_SANITIZE)
  message(STATUS "npm or node is missing: `vitrine view`, `vitrine mark` and `vitrine ct` will have no page (Debian: apt-get install nodejs npm)")
endif()

# vitrine_page(stage): called in the folder of the stage.
function(vitrine_page stage)
  if(NOT TARGET vitrine_page OR NOT TARGET vitrine-${stage})
    return()
  endif()
  set(page ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/vitrine-${stage}.html)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/page/* ${VITRINE_PAGES_HOME}/*)
  add_custom_command(OUTPUT ${page}
    COMMAND ${CMAKE_COMMAND} -DNODE=${NODE} -DSTAGE=${stage} -DFROM=${CMAKE_CURRENT_SOURCE_DIR}/page -DSHARED=${VITRINE_PAGES_HOME}
            -DWORK=${VITRINE_PAGES_WORK} -DPAGE=${page} -P ${VITRINE_PAGES_HOME}/bundle.cmake
    DEPENDS ${sources} ${VITRINE_PAGES_PACKAGES}
    COMMENT "page of vitrine ${stage}" VERBATIM)
  add_custom_target(vitrine_page_${stage} ALL DEPENDS ${page})
  add_dependencies(vitrine_page_${stage} vitrine_page_packages)
  add_dependencies(vitrine_page vitrine_page_${stage})
endfunction()
