# Installs pantin into a prefix of its own, then builds and runs a project that finds it there: by
# find_package, and by pkg-config where there is one.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed WORKING_DIRECTORY ${WORK})
  if(failed)
    list(JOIN ARGN " " line)
    message(FATAL_ERROR "failed (${failed}): ${line}")
  endif()
endfunction()

function(compile_as_described program)
  execute_process(COMMAND ${PKG_CONFIG} ${ARGN} --cflags --libs ${module_of_${program}}
                  OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(
    flags UNIX_COMMAND
    "${FLAGS} -std=c++20 ${SOURCE}/${program}.cpp -o described_${program} ${flags}")
  run(${COMPILER} ${flags})
  run(${WORK}/described_${program})
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
set(prefix ${WORK}/moved)
# Moved after the install: neither the package nor the .pc file may hold absolute paths.
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/installed)
file(RENAME ${WORK}/installed ${prefix})

run(${PYTHON} -B ${SOURCE}/headers.py ${prefix}/include ${COMPILER} ${FLAGS})

run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${prefix}
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS} -DCMAKE_BUILD_TYPE=${TYPE}
    -DWITH_SCENE=${SCENE} -DWITH_RENDER=${RENDER})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/door)
if(SCENE)
  run(${WORK}/build/read_scene)
endif()
if(RENDER)
  run(${WORK}/build/save_picture)
endif()

# What the installed program says of itself is what was installed beside it.
if(EXISTS ${prefix}/bin/pantin)
  foreach(page IN ITEMS "man/man1/pantin.1|help --man"
                        "bash-completion/completions/pantin|completion bash"
                        "zsh/site-functions/_pantin|completion zsh"
                        "fish/vendor_completions.d/pantin.fish|completion fish")
    string(REGEX MATCH "^(.*)[|](.*)$" _ ${page})
    separate_arguments(words UNIX_COMMAND "${CMAKE_MATCH_2}")
    file(READ ${prefix}/share/${CMAKE_MATCH_1} installed)
    execute_process(COMMAND ${prefix}/bin/pantin ${words} OUTPUT_VARIABLE told COMMAND_ERROR_IS_FATAL ANY)
    if(NOT installed STREQUAL told)
      message(FATAL_ERROR "share/${CMAKE_MATCH_1} is not what `pantin ${CMAKE_MATCH_2}` prints")
    endif()
  endforeach()
endif()

if(EXISTS ${prefix}/share/pantin AND NOT EXISTS ${prefix}/share/pantin/scenes/chain.json)
  message(FATAL_ERROR "the scenes are not installed")
endif()
file(GLOB_RECURSE pictures ${prefix}/*.png ${prefix}/*.gif ${prefix}/*.webp)
if(pictures)
  message(FATAL_ERROR "pictures of the README are installed: ${pictures}")
endif()

# The library links by what pkg-config says, told that it is static or not.
find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  set(ENV{PKG_CONFIG_PATH} ${prefix}/${LIBDIR}/pkgconfig)
  set(module_of_door pantin)
  set(module_of_read_scene pantin-scene)
  set(module_of_save_picture pantin-render)
  set(programs door)
  if(SCENE)
    list(APPEND programs read_scene)
  endif()
  if(RENDER)
    list(APPEND programs save_picture)
  endif()
  foreach(program IN LISTS programs)
    compile_as_described(${program})
  endforeach()
  compile_as_described(door --static)
endif()
