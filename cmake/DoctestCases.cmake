# Makes every test case of a doctest program a CTest test. Names are sentences with laws in them: commas, semicolons and
# half-open intervals [0, 1) must survive, which CMake's lists and so doctest's own module do not allow.
#
# Included, it defines the function; run as a script after linking (with PROGRAM, PREFIX, SECONDS, OUTPUT) it writes the list.
if(NOT CMAKE_SCRIPT_MODE_FILE)
  function(balance_discover_cases target prefix)
    set(output ${CMAKE_CURRENT_BINARY_DIR}/${target}_cases.cmake)
    set(seconds 120)
    if(BALANCE_SANITIZE)
      set(seconds 600)
    endif()
    add_custom_command(
      TARGET ${target}
      POST_BUILD
      BYPRODUCTS ${output}
      COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:${target}> -D PREFIX=${prefix} -D SECONDS=${seconds} -D OUTPUT=${output} -P
              ${CMAKE_CURRENT_FUNCTION_LIST_FILE}
      VERBATIM)
    # Before the first build there is no list: a test that says so, rather than silence.
    set(include_file ${CMAKE_CURRENT_BINARY_DIR}/${target}_include.cmake)
    file(WRITE ${include_file} "if(EXISTS \"${output}\")\n  include(\"${output}\")\nelse()\n"
                               "  add_test(${target}_NOT_BUILT ${target}_NOT_BUILT)\nendif()\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${include_file})
  endfunction()
  return()
endif()

execute_process(COMMAND ${PROGRAM} --list-test-cases --no-version --no-colors OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
set(tests "")
while(NOT listing STREQUAL "")
  string(FIND "${listing}" "\n" end)
  string(SUBSTRING "${listing}" 0 ${end} name)
  math(EXPR next "${end} + 1")
  string(SUBSTRING "${listing}" ${next} -1 listing)
  if(name MATCHES "^(====|\\[doctest\\])" OR name STREQUAL "")
    continue()
  endif()
  string(REPLACE "," "\\," filter "${name}")
  # A filter that finds no case would run nothing and pass, hence the expression that fails it.
  string(APPEND tests "add_test([==[${PREFIX}: ${name}]==] [==[${PROGRAM}]==] [==[--test-case=${filter}]==])\n"
                      "set_tests_properties([==[${PREFIX}: ${name}]==] PROPERTIES TIMEOUT ${SECONDS} LABELS ${PREFIX} "
                      "FAIL_REGULAR_EXPRESSION [==[test cases: +0 ]==])\n")
endwhile()
file(WRITE ${OUTPUT} "${tests}")
