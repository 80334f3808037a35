# `cmake --build <folder> --target uninstall` removes what `cmake --install <folder>` has put in place (cmake/RemoveInstalled.cmake). Which of
# the folders that others use, too, are there before is recorded first: those stay.
set(shared_folders
    ${CMAKE_INSTALL_BINDIR}
    ${CMAKE_INSTALL_INCLUDEDIR}
    ${CMAKE_INSTALL_LIBDIR}/cmake
    ${CMAKE_INSTALL_DATAROOTDIR}/doc
    ${CMAKE_INSTALL_MANDIR}/man1
    ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
    ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
    ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(CODE "set(shared_folders \"${shared_folders}\")
  set(record_folder \"${PROJECT_BINARY_DIR}\")
  include(\"${PROJECT_SOURCE_DIR}/cmake/RecordFolders.cmake\")" ALL_COMPONENTS)

if(PROJECT_IS_TOP_LEVEL)
  add_custom_target(
    uninstall
    COMMAND ${CMAKE_COMMAND} -D "BUILD_FOLDER=${PROJECT_BINARY_DIR}" -P ${PROJECT_SOURCE_DIR}/cmake/RemoveInstalled.cmake
    COMMENT ""
    VERBATIM)
endif()
