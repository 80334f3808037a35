# Manual pages and shell completions, made by the program itself from the definitions that it parses with.
set(help_files_dir ${CMAKE_CURRENT_BINARY_DIR}/help)

function(balance_make_help_files target)
  if(CMAKE_CROSSCOMPILING)
    return() # the program does not run here
  endif()
  set(compress "")
  find_program(GZIP_PROGRAM gzip)
  mark_as_advanced(GZIP_PROGRAM)
  if(GZIP_PROGRAM) # as Debian wants it; without a time of day, so that the same pages are the same bytes
    set(compress COMMAND ${GZIP_PROGRAM} -9 -n -r ${help_files_dir}/man1)
  endif()
  # Part of the program's own target, so that a built program can be installed.
  add_custom_command(
    TARGET ${target}
    POST_BUILD
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${help_files_dir}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${help_files_dir}/man1
    COMMAND ${target} man --all ${help_files_dir}/man1
    COMMAND ${target} completion bash > ${help_files_dir}/balance
    COMMAND ${target} completion zsh > ${help_files_dir}/_balance
    COMMAND ${target} completion fish > ${help_files_dir}/balance.fish
    ${compress}
    COMMENT "Manual pages and shell completions")
  # Where Debian's own packages put theirs, and where each shell looks by itself.
  install(DIRECTORY ${help_files_dir}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR})
  install(FILES ${help_files_dir}/balance DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(FILES ${help_files_dir}/_balance DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
  install(FILES ${help_files_dir}/balance.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endfunction()
