# cmake -DNPM= -DFROM=page -DWORK=folder -P install.cmake: installs what package-lock.json names into WORK. Without a registry there
# is a note and there are no pages: the next build tries again.
file(MAKE_DIRECTORY ${WORK})
file(COPY ${FROM}/package.json ${FROM}/package-lock.json DESTINATION ${WORK})
execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline
                WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(failed)
  file(REMOVE_RECURSE ${WORK}/node_modules)
  message("note: `vitrine view` and `vitrine mark` have no page: npm could not install their packages:\n${said}")
endif()
