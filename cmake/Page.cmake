# The scripts of the page that `balance report` writes: bundled from web/ with esbuild into the build folder and embedded in
# the library. Packages come by npm, once per build folder and version of web/package-lock.json. Without node, npm or a
# network everything else is built, and `balance report` says what is missing.
find_program(NODE_PROGRAM NAMES node nodejs)
find_program(NPM_PROGRAM npm)
mark_as_advanced(NODE_PROGRAM NPM_PROGRAM)
set(node_suits OFF)
if(NODE_PROGRAM AND NPM_PROGRAM)
  execute_process(COMMAND ${NODE_PROGRAM} --version OUTPUT_VARIABLE node_version OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(node_version MATCHES "^v([0-9]+)" AND CMAKE_MATCH_1 GREATER_EQUAL 18)
    set(node_suits ON)
  endif()
endif()
# Where node is missing now it may be there at the next configuration.
option(BALANCE_PAGE "Bundle the scripts of `balance report` (needs node 18 or newer, npm and its packages)" ON)

set(page_folder ${PROJECT_BINARY_DIR}/web)
set(page_bundle ${page_folder}/bundle)
set(page_outputs ${page_bundle}/planar.js ${page_bundle}/spatial.js ${page_bundle}/page.css)
if(BALANCE_PAGE AND node_suits)
  # Tests drive a browser, which takes a package more.
  set(npm_omit --omit=dev)
  if(BALANCE_TESTS)
    set(npm_omit "")
  endif()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/package-lock.json)
  file(SHA256 ${PROJECT_SOURCE_DIR}/web/package-lock.json page_lock)
  set(page_stamp ${page_folder}/packages-${page_lock}${npm_omit}.stamp)
  if(NOT EXISTS ${page_stamp})
    message(STATUS "Fetching the packages of the report's page")
    file(COPY ${PROJECT_SOURCE_DIR}/web/package.json ${PROJECT_SOURCE_DIR}/web/package-lock.json DESTINATION ${page_folder})
    execute_process(
      COMMAND ${NPM_PROGRAM} ci --ignore-scripts --prefer-offline --no-audit --no-fund --loglevel=error ${npm_omit}
      WORKING_DIRECTORY ${page_folder} RESULT_VARIABLE npm_result)
    if(npm_result EQUAL 0)
      file(TOUCH ${page_stamp})
    endif()
  endif()
endif()
if(BALANCE_PAGE AND EXISTS "${page_stamp}")
  file(GLOB_RECURSE page_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/src/*)
  add_custom_command(
    OUTPUT ${page_outputs}
    COMMAND ${NODE_PROGRAM} ${PROJECT_SOURCE_DIR}/web/build.mjs ${page_folder}
    DEPENDS ${page_stamp} ${PROJECT_SOURCE_DIR}/web/build.mjs ${page_sources}
    COMMENT "Bundling the report's page"
    VERBATIM)
  add_custom_target(balance_page DEPENDS ${page_outputs})
  add_dependencies(balance_interface balance_page)
  set_source_files_properties(
    ${PROJECT_SOURCE_DIR}/lib/balance/interface/reports/html_report.cpp
    PROPERTIES COMPILE_DEFINITIONS BALANCE_PAGE_BUNDLE="${page_bundle}" OBJECT_DEPENDS "${page_outputs}")
else()
  set(BALANCE_PAGE OFF)
  message(STATUS "balance report is left out: it needs node 18 or newer, npm, npm's packages (and BALANCE_PAGE=ON)")
endif()
