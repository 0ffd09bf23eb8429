# Builds a project that takes pantin's sources in, and looks at how its own files are compiled.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output
                  WORKING_DIRECTORY ${WORK})
  if(failed)
    list(JOIN ARGN " " line)
    message(FATAL_ERROR "failed (${failed}): ${line}\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
    -DPANTIN=${PANTIN} -DBUILD_SHARED_LIBS=ON -DPANTIN_WERROR=ON -DPANTIN_PLAIN_CPP=ON
    -DPANTIN_TBB=OFF -DPANTIN_SCENE=OFF -DPANTIN_RENDER=OFF)
run(${CMAKE_COMMAND} --build ${WORK}/build --parallel 2)
run(${WORK}/build/own)
run(${WORK}/build/door)

file(READ ${WORK}/build/compile_commands.json commands)
string(JSON count LENGTH "${commands}")
math(EXPR last "${count} - 1")
set(seen 0)
foreach(i RANGE ${last})
  string(JSON file GET "${commands}" ${i} file)
  string(JSON command GET "${commands}" ${i} command)
  if(NOT file MATCHES "/(own|door)\\.cpp$")
    continue()
  endif()
  math(EXPR seen "${seen} + 1")
  if(command MATCHES " (-W[^ ]*|-f(fp|no-math)[^ ]*|-O[^ ]*|-DPANTIN[^ ]*|-include) ")
    message(FATAL_ERROR "${file} is compiled with an option of pantin: ${command}")
  endif()
  # The parent's own choice: GNU's extensions, which pantin does without.
  if(NOT command MATCHES " -std=gnu\\+\\+(17|20|2a) " AND command MATCHES "-std=")
    message(FATAL_ERROR "${file} is compiled by pantin's standard: ${command}")
  endif()
endforeach()
if(NOT seen EQUAL 2)
  message(FATAL_ERROR "found ${seen} files of the parent, expected 2")
endif()

# Nothing of pantin is installed or tested unless it is asked for.
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/installed)
file(GLOB_RECURSE installed ${WORK}/installed/*)
if(installed)
  message(FATAL_ERROR "installed without being asked for: ${installed}")
endif()
execute_process(COMMAND ${CMAKE_CTEST_COMMAND} -N --test-dir ${WORK}/build OUTPUT_VARIABLE tests)
if(tests MATCHES "Total Tests: [1-9]")
  message(FATAL_ERROR "tests of pantin within another project: ${tests}")
endif()

# Asked for, the shared library installs like the other.
run(${CMAKE_COMMAND} -DPANTIN_INSTALL=ON ${WORK}/build)
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/installed)
run(${CMAKE_COMMAND} -S ${SOURCE}/../consumer -B ${WORK}/consumer -G ${GENERATOR}
    -DCMAKE_PREFIX_PATH=${WORK}/installed -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/door)
