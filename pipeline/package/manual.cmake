# Run when vitrine is installed: manual pages of the commands, made by help2man from what they say of themselves (without help2man there are
# none), and the Debian changelog. PROGRAM, MANUAL, DOCUMENTS, WORK, VERSION, CONTACT: set by package.cmake.
find_program(GZIP gzip REQUIRED)
function(compress text file)
  file(WRITE ${file} "${text}")
  execute_process(COMMAND ${GZIP} -9nf ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH, where it is set
compress("vitrine (${VERSION}) unstable; urgency=medium\n\n  * Built from the sources of version ${VERSION}.\n\n -- ${CONTACT}  ${now}\n"
         ${DOCUMENTS}/changelog)

find_program(HELP2MAN help2man)
if(NOT HELP2MAN)
  message(STATUS "no manual pages: help2man is missing")
  return()
endif()
file(MAKE_DIRECTORY ${MANUAL} ${WORK})
# help2man names a page after its program, and knows "Usage:": one starter a command.
function(page name arguments summary)
  file(WRITE ${WORK}/${name} "#!/bin/sh\n${PROGRAM} ${arguments} \"$@\" | sed 's/^usage: /Usage: /'\n")
  file(CHMOD ${WORK}/${name} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  execute_process(COMMAND ${HELP2MAN} --no-info --version-string=${VERSION} "--name=${summary}" ${WORK}/${name}
                  OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  compress("${text}" ${MANUAL}/${name}.1)
endfunction()

execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
page(vitrine "" "photos in, a relightable scene out")
string(REPLACE ";" "@semicolon@" help "${help}")  # which divides lists
string(REGEX MATCHALL "\n  [a-z]+ +[^\n]+" commands "${help}")
foreach(line ${commands})
  string(REGEX REPLACE "\n  ([a-z]+) +(.*)" "\\1" command "${line}")
  string(REGEX REPLACE "\n  ([a-z]+) +(.*)" "\\2" summary "${line}")
  string(REPLACE "@semicolon@" ";" summary "${summary}")
  page(vitrine-${command} ${command} "${summary}")
endforeach()
