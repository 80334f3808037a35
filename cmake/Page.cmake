# The scripts of the page that `balance report` writes: bundled from web/ with esbuild into the build folder and embedded in
# the library. Packages come by npm, once per build folder and version of web/package-lock.json. Without node and npm
# everything else is built, and `balance report` says what is missing.
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
option(BALANCE_PAGE "Bundle the scripts of `balance report` (needs node 18 or newer, npm and its packages)" ${node_suits})

set(page_folder ${PROJECT_BINARY_DIR}/web)
set(page_bundle ${page_folder}/bundle)
set(page_outputs ${page_bundle}/planar.js ${page_bundle}/spatial.js ${page_bundle}/page.css)
if(BALANCE_PAGE AND node_suits)
  file(GLOB_RECURSE page_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/web/src/*)
  # Tests drive a browser, which takes a package more.
  set(npm_omit --omit=dev)
  if(BALANCE_TESTS)
    set(npm_omit "")
  endif()
  add_custom_command(
    OUTPUT ${page_folder}/packages.stamp
    COMMAND ${CMAKE_COMMAND} -E make_directory ${page_folder}
    COMMAND ${CMAKE_COMMAND} -E copy ${PROJECT_SOURCE_DIR}/web/package.json ${PROJECT_SOURCE_DIR}/web/package-lock.json
            ${page_folder}
    COMMAND ${CMAKE_COMMAND} -E chdir ${page_folder} ${NPM_PROGRAM} ci --ignore-scripts --prefer-offline --no-audit
            --no-fund --loglevel=error ${npm_omit}
    COMMAND ${CMAKE_COMMAND} -E touch ${page_folder}/packages.stamp
    DEPENDS ${PROJECT_SOURCE_DIR}/web/package.json ${PROJECT_SOURCE_DIR}/web/package-lock.json
    COMMENT "Packages of the report's page (without network: -DBALANCE_PAGE=OFF)"
    VERBATIM)
  add_custom_command(
    OUTPUT ${page_outputs}
    COMMAND ${NODE_PROGRAM} ${PROJECT_SOURCE_DIR}/web/build.mjs ${page_folder}
    DEPENDS ${page_folder}/packages.stamp ${PROJECT_SOURCE_DIR}/web/build.mjs ${page_sources}
    COMMENT "Bundling the report's page"
    VERBATIM)
  add_custom_target(balance_page DEPENDS ${page_outputs})
  add_dependencies(balance balance_page)
  set_source_files_properties(
    ${PROJECT_SOURCE_DIR}/lib/balance/report/page_assets.cpp
    PROPERTIES COMPILE_DEFINITIONS BALANCE_PAGE_BUNDLE="${page_bundle}" OBJECT_DEPENDS "${page_outputs}")
else()
  set(BALANCE_PAGE OFF)
  message(STATUS "balance report is left out: it needs node 18 or newer and npm (and BALANCE_PAGE=ON)")
endif()
