# Installation in the layout of the FHS, and the Debian package: `cmake --install BUILD`, or `cd BUILD && cpack` for the .deb.
#
#   bin/vitrine                     a link to lib/vitrine/vitrine
#   lib/vitrine/                    all programs, their descriptions, codecs and pages: they find each other beside themselves
#   share/vitrine/configs           presets, lights
#   lib/python3/dist-packages       the Python package, if it was built
#   share/man/man1, share/bash-completion, share/doc/vitrine
include(GNUInstallDirs)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY TRUE)  # tests are not installed

# Linked into every program.
add_library(vitrine_processor_check OBJECT pipeline/package/processor_check.cpp)
target_compile_options(vitrine_processor_check PRIVATE -march=x86-64 -O1 -fno-sanitize=all)

set(home lib/vitrine)  # not the multiarch folder: programs, no libraries for others

set(programs vitrine vitrine-report vitrine-farm vitrine_codecs vitrine_camera_codecs)
foreach(stage ${VITRINE_STAGES} ${VITRINE_TOOLS})
  list(APPEND programs vitrine-${stage})
  install(FILES ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/vitrine-${stage}.json DESTINATION ${home})
endforeach()
foreach(program ${programs})
  if(NOT TARGET ${program})
    return()  # a sanitized build without stages
  endif()
endforeach()
install(TARGETS ${programs} RUNTIME DESTINATION ${home} LIBRARY DESTINATION ${home})
install(FILES ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/vitrine.stages DESTINATION ${home})
foreach(page view mark tomography)
  install(FILES ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/vitrine-${page}.html DESTINATION ${home} OPTIONAL)
endforeach()
install(DIRECTORY configs/ DESTINATION ${CMAKE_INSTALL_DATADIR}/vitrine/configs)
install(FILES pipeline/package/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME vitrine)
install(FILES README.md pipeline/package/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
set(python_depends)
if(TARGET vitrine_python)
  set(python_home lib/python3/dist-packages/vitrine)  # Debian's python3 searches it below /usr
  install(TARGETS vitrine_python LIBRARY DESTINATION ${python_home})
  install(DIRECTORY pipeline/python/vitrine/ DESTINATION ${python_home} PATTERN __pycache__ EXCLUDE)
  install(CODE "
    if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr/local\")  # where Debian's python3 searches another folder
      set(packages \$ENV{DESTDIR}/usr/local/lib/python${VITRINE_PYTHON_VERSION}/dist-packages)
      file(MAKE_DIRECTORY \${packages})
      file(CREATE_LINK ../../python3/dist-packages/vitrine \${packages}/vitrine SYMBOLIC)
    endif()")
  # The native module is of one minor version of Python.
  string(REGEX REPLACE "^3\\.([0-9]+)$" "\\1" minor ${VITRINE_PYTHON_VERSION})
  math(EXPR next "${minor} + 1")
  set(python_depends ", python3 (>= ${VITRINE_PYTHON_VERSION}), python3 (<< 3.${next}), python3-numpy")
endif()
install(CODE "
  file(MAKE_DIRECTORY \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR})
  file(CREATE_LINK ../${home}/vitrine \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}/vitrine SYMBOLIC)
  set(PROGRAM ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/vitrine)
  set(MANUAL \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1)
  set(DOCUMENTS \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DOCDIR})
  set(WORK ${CMAKE_BINARY_DIR}/manual)
  set(VERSION ${VITRINE_VERSION})
  set(CONTACT \"${VITRINE_CONTACT}\")
  include(${PROJECT_SOURCE_DIR}/pipeline/package/manual.cmake)")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME vitrine)
set(CPACK_PACKAGE_VERSION ${VITRINE_VERSION})
set(CPACK_PACKAGE_CONTACT "${VITRINE_CONTACT}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "photos in, a relightable scene out, glass and mirrors included")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Turns a folder of photos into a scene that can be rendered from new places and
under new lights, with its glass and its mirrors. One command estimates camera
poses (COLMAP), finds masks, trains 2D Gaussian surfels, extracts a mesh,
separates albedo from light and exports Gaussians and meshes. It needs no GPU,
but a processor with AVX2.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "colmap${python_depends}")
# Films; decoders of HEIC and AVIF, which are packages of their own since Debian 13.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "ffmpeg, libheif-plugin-libde265, libheif-plugin-dav1d")
include(CPack)
