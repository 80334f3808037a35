# The program `balance`.
include(cmake/HelpFiles.cmake)
include(cmake/Starters.cmake)

file(GLOB_RECURSE app_sources CONFIGURE_DEPENDS app/*.cpp)
if(app_sources)
  add_executable(balance_app ${app_sources})
  set_target_properties(balance_app PROPERTIES OUTPUT_NAME balance)
  target_include_directories(balance_app PRIVATE app)
  target_link_libraries(balance_app PRIVATE balance::balance ${balance_app_libraries})
  # The HDF5 package names every library that HDF5 itself may use; the program needs few of them.
  target_link_options(balance_app PRIVATE LINKER:--as-needed)
  balance_compile_options(balance_app)
  balance_harden(balance_app)
  balance_optimise_little(balance_app)
  balance_embed_starters(balance_app)
  balance_make_help_files(balance_app)
  balance_compile_together(balance_app)
endif()
