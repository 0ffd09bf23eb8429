# Installs the manual page and the completions of shells; run by `cmake --install`.
#   PROGRAM  pantin, which writes them
#   WORK     a folder for them until then
#   MAN      the folder of manual pages
#   DATA     the folder that shells look for completions in
cmake_policy(VERSION 3.22)
function(write_and_install file to)
  file(MAKE_DIRECTORY ${WORK})
  execute_process(COMMAND ${PROGRAM} ${ARGN} OUTPUT_FILE ${WORK}/${file} COMMAND_ERROR_IS_FATAL ANY)
  file(INSTALL ${WORK}/${file} DESTINATION ${to})
endfunction()
write_and_install(pantin.1 ${MAN}/man1 help --man)
write_and_install(pantin ${DATA}/bash-completion/completions completion bash)
write_and_install(_pantin ${DATA}/zsh/site-functions completion zsh)
write_and_install(pantin.fish ${DATA}/fish/vendor_completions.d completion fish)
