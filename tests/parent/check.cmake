# Configures a project that takes pantin's sources in, in several ways: it stays as it is, and gets
# libraries only. With WHOLE it is built as well, and how its own files are compiled is looked at.
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

function(configure folder)
  run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/${folder} -G ${GENERATOR}
      -DCMAKE_CXX_COMPILER=${COMPILER} -DPANTIN=${PANTIN} ${ARGN})
endfunction()

if(NOT WHOLE)
  configure(as_it_is)
  # Nothing of pantin is installed or tested unless it is asked for.
  run(${CMAKE_COMMAND} --install ${WORK}/as_it_is --prefix ${WORK}/installed)
  file(GLOB_RECURSE installed ${WORK}/installed/*)
  if(installed)
    message(FATAL_ERROR "installed without being asked for: ${installed}")
  endif()
  execute_process(COMMAND ${CMAKE_CTEST_COMMAND} -N --test-dir ${WORK}/as_it_is OUTPUT_VARIABLE tests)
  if(NOT tests MATCHES "Total Tests: 0")
    message(FATAL_ERROR "tests of pantin within another project: ${tests}")
  endif()
  configure(fetched -DFETCH=ON -DOWN_GLM=ON)
  # A package of pantin names glm's, though here glm is no package.
  configure(packaged -DOWN_GLM=ON -DPANTIN_INSTALL=ON)
  return()
endif()

configure(build -DFETCH=ON -DOWN_GLM=ON -DBUILD_SHARED_LIBS=ON -DPANTIN_WERROR=ON
          -DPANTIN_PLAIN_CPP=ON -DPANTIN_TBB=OFF -DPANTIN_PLANAR=OFF -DPANTIN_SCENE=OFF -DPANTIN_RENDER=OFF)
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

# Asked for, the shared library installs like the other.
run(${CMAKE_COMMAND} -DPANTIN_INSTALL=ON ${WORK}/build)
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/installed)
run(${CMAKE_COMMAND} -S ${SOURCE}/../consumer -B ${WORK}/consumer -G ${GENERATOR}
    -DCMAKE_PREFIX_PATH=${WORK}/installed -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/door)

# pkg-config finds it, too.
find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  file(GLOB_RECURSE described ${WORK}/installed/pantin.pc)
  cmake_path(GET described PARENT_PATH folder)
  cmake_path(GET folder PARENT_PATH libraries)
  set(ENV{PKG_CONFIG_PATH} ${folder})
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs pantin OUTPUT_VARIABLE flags
                  COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(
    flags UNIX_COMMAND
    "-std=c++20 ${SOURCE}/../consumer/door.cpp -o described -Wl,-rpath,${libraries} ${flags}")
  run(${COMPILER} ${flags})
  run(${WORK}/described)
endif()
