# cmake -DNPM= -DNODE= -DFROM=page -DWORK=folder -DPAGE=file.html -P bundle.cmake: installs what page/package-lock.json names into
# WORK and writes PAGE. Without a registry there is a note and no page: the next build tries again.
file(GLOB sources ${FROM}/*)
file(MAKE_DIRECTORY ${WORK})
file(COPY ${sources} DESTINATION ${WORK})
execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline
                WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT failed)
  execute_process(COMMAND ${NODE} bundle.mjs ${PAGE} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE broken)
  if(broken)
    message(FATAL_ERROR "the page of `vitrine view` could not be bundled")
  endif()
else()
  file(REMOVE ${PAGE})
  message("note: `vitrine view` has no page: npm could not install its packages:\n${said}")
endif()
