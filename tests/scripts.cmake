# Scripts and configs as tests. A script passes when it ends with exit code 0; it finds the program in BALANCE and the
# mechanisms in CONFIGS. Names that begin with an underscore are helpers.
set(configs ${PROJECT_SOURCE_DIR}/configs)

set(slowness 1)
set(script_seconds 300)
if(BALANCE_SANITIZE)
  set(slowness 5)
  set(script_seconds 600)
endif()

function(balance_add_script_test name)
  add_test(NAME ${name} COMMAND ${ARGN})
  set(environment BALANCE=$<TARGET_FILE:balance_app> CONFIGS=${configs} PYTHON=${BALANCE_PYTHON} SLOWNESS=${slowness})
  set_tests_properties(${name} PROPERTIES ENVIRONMENT "${environment}" TIMEOUT ${script_seconds})
endfunction()

add_test(NAME layers COMMAND ${BALANCE_PYTHON} ${PROJECT_SOURCE_DIR}/scripts/check_layers)
add_test(NAME layers.self-test COMMAND ${BALANCE_PYTHON} ${PROJECT_SOURCE_DIR}/scripts/check_layers --self-test)
add_test(NAME names COMMAND ${BALANCE_PYTHON} ${PROJECT_SOURCE_DIR}/scripts/check_names)
add_test(NAME names.self-test COMMAND ${BALANCE_PYTHON} ${PROJECT_SOURCE_DIR}/scripts/check_names --self-test)

if(TARGET balance_app)
  add_test(NAME equations.index COMMAND ${BALANCE_PYTHON} ${PROJECT_SOURCE_DIR}/scripts/check_equations $<TARGET_FILE:balance_app>)
  if(NOT BALANCE_SANITIZE)
    add_test(NAME install COMMAND bash ${CMAKE_CURRENT_SOURCE_DIR}/install/run.sh ${PROJECT_BINARY_DIR} ${CMAKE_COMMAND})
    set_tests_properties(install PROPERTIES TIMEOUT 300 LABELS slow)
  endif()

  file(GLOB_RECURSE scripts CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} cli/*.py test_*.py)
  list(REMOVE_DUPLICATES scripts)
  list(FILTER scripts EXCLUDE REGEX "(^|/)_[^/]*$")
  foreach(script IN LISTS scripts)
    balance_add_script_test(${script} ${BALANCE_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/${script})
    # minutes under sanitizers, or a size of files that their profiles exceed
    if(script MATCHES "^reference_implementation/|^docs/|^cli/(affine|assembly_lines|conditions|control_suite|determinism|published|result_files|starters)")
      set_tests_properties(${script} PROPERTIES LABELS slow)
    endif()
  endforeach()

  if(BALANCE_PYTHON_MODULE)
    file(GLOB scripts CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} python/*.py)
    list(FILTER scripts EXCLUDE REGEX "(^|/)_[^/]*$")
    foreach(script IN LISTS scripts)
      balance_add_script_test(${script} ${Python_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/${script})
      set_property(TEST ${script} APPEND PROPERTY ENVIRONMENT PYTHONPATH=${PROJECT_BINARY_DIR}/python)
    endforeach()
  endif()

  if(BALANCE_PAGE AND NOT BALANCE_SANITIZE)
    find_program(CHROMIUM_PROGRAM NAMES chromium chromium-browser google-chrome)
    mark_as_advanced(CHROMIUM_PROGRAM)
    foreach(readers IN ITEMS report access)
      add_test(NAME browser.${readers} COMMAND ${NODE_PROGRAM} ${CMAKE_CURRENT_SOURCE_DIR}/browser/${readers}.mjs
                                               $<TARGET_FILE:balance_app> ${configs} ${PROJECT_BINARY_DIR}/pages)
      set_tests_properties(
        browser.${readers} PROPERTIES ENVIRONMENT "PAGE_PACKAGES=${PROJECT_BINARY_DIR}/web;CHROMIUM=${CHROMIUM_PROGRAM}" TIMEOUT 600
                                      SKIP_RETURN_CODE 77)
    endforeach()
  endif()

  file(GLOB shell_scripts CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} cli/*.sh)
  list(FILTER shell_scripts EXCLUDE REGEX "(^|/)_[^/]*$")
  foreach(script IN LISTS shell_scripts)
    balance_add_script_test(${script} bash ${CMAKE_CURRENT_SOURCE_DIR}/${script})
  endforeach()

  file(GLOB specs CONFIGURE_DEPENDS ${configs}/*.yaml)
  foreach(spec IN LISTS specs)
    get_filename_component(name ${spec} NAME_WE)
    # What kind of file it is can change without its name changing.
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${spec})
    file(STRINGS ${spec} bodies REGEX "^bodies:")
    file(STRINGS ${spec} motion REGEX "^motion:")
    if(bodies)
      balance_add_script_test(config.check.${name} $<TARGET_FILE:balance_app> check ${spec})
    endif()
    if(motion)
      balance_add_script_test(config.simulate.${name} ${BALANCE_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/run_config.py ${spec})
    endif()
  endforeach()
endif()
