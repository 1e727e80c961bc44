# cmake -DNPM= -DFROM=folder -DWORK=folder -DWITHOUT="what then is missing" -P install.cmake: installs what FROM/package-lock.json names into
# WORK. Without a registry there is a note: the next build tries again.
file(MAKE_DIRECTORY ${WORK})
file(COPY ${FROM}/package.json ${FROM}/package-lock.json DESTINATION ${WORK})
execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline
                WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(failed)
  file(REMOVE_RECURSE ${WORK}/node_modules)
  message("note: ${WITHOUT}: npm could not install the packages of ${FROM}:\n${said}")
endif()
