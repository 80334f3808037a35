# The headers that users of the library include, part by part. They alone are installed, with what they include themselves; and they
# make the umbrella <balance/balance.hpp>. All others are the library's own: see "Private to" in their first lines.
set(balance_public_core
    base/error.hpp
    base/rotation.hpp
    base/types.hpp
    base/version.hpp
    dynamics/parameter.hpp
    inverse/inverse_dynamics.hpp
    model/mechanism.hpp
    model/validate.hpp
    motion/law.hpp
    motion/motion.hpp
    motion/names.hpp
    motion/sample.hpp
    motion/trajectory.hpp
    result/body_poses.hpp
    result/metrics.hpp
    result/quantities.hpp
    result/result.hpp
    simulation/simulate.hpp
    study/study.hpp)
set(balance_public_gradients gradients/mechanism_number.hpp gradients/state_gradient.hpp)
set(balance_public_reading spec/read_spec.hpp)
set(balance_public_writing write/balanced_spec.hpp write/result_csv.hpp write/result_hdf5.hpp write/text.hpp)
set(balance_public_design
    analysis/check.hpp
    analysis/control.hpp
    analysis/design_study.hpp
    analysis/figure_gradient.hpp
    analysis/robust_figure.hpp
    analysis/verify.hpp
    conditions/conditions.hpp
    conditions/latex.hpp
    conditions/modular.hpp
    conditions/text.hpp)
set(balance_public_comparing compare/comparison.hpp compare/verdict.hpp read/requirement.hpp read/result_file.hpp)
set(balance_public_importing import/export_masses.hpp import/import.hpp)
set(balance_public_pages report/page.hpp)

set(balance_umbrella
    "#pragma once\n/// Everything that users of the library include; <balance/…> of their own are in the same place.\n")
set(balance_installed_headers "")
foreach(part core gradients reading writing design comparing importing pages)
  if(NOT TARGET balance_${part})
    continue()
  endif()
  string(APPEND balance_umbrella "\n// balance::${part}\n")
  foreach(header IN LISTS balance_public_${part})
    string(APPEND balance_umbrella "#include \"balance/${header}\"\n")
    list(APPEND balance_installed_headers ${header})
  endforeach()
endforeach()
set(generated ${PROJECT_BINARY_DIR}/generated)
file(CONFIGURE OUTPUT ${generated}/balance/balance.hpp CONTENT "${balance_umbrella}" @ONLY)

# What they include, and what that includes.
set(waiting ${balance_installed_headers})
while(waiting)
  list(POP_FRONT waiting header)
  set(file ${PROJECT_SOURCE_DIR}/lib/balance/${header})
  if(NOT EXISTS ${file})
    continue() # generated
  endif()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(STRINGS ${file} lines REGEX "^#include \"balance/")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^#include \"balance/([^\"]+)\".*" "\\1" included "${line}")
    if(NOT included IN_LIST balance_installed_headers)
      list(APPEND balance_installed_headers ${included})
      list(APPEND waiting ${included})
    endif()
  endforeach()
endwhile()

foreach(header IN LISTS balance_installed_headers)
  cmake_path(GET header PARENT_PATH room)
  set(file ${PROJECT_SOURCE_DIR}/lib/balance/${header})
  if(NOT EXISTS ${file})
    set(file ${generated}/balance/${header})
  endif()
  install(FILES ${file} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/balance/${room})
endforeach()
install(FILES ${generated}/balance/balance.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/balance)
