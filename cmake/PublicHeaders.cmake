# The headers that users of the library include, part by part. They alone are installed, with what they include themselves; and they
# make the umbrella <balance/balance.hpp>. All others are the library's own.
set(balance_public_core
    foundation/base/error.hpp
    foundation/base/file_error.hpp
    foundation/base/rotation.hpp
    foundation/base/types.hpp
    foundation/base/version.hpp
    mechanics/model/mechanism.hpp
    mechanics/model/validation.hpp
    mechanics/trajectory/motion_law.hpp
    mechanics/trajectory/motion_outcome.hpp
    mechanics/trajectory/motion_sample.hpp
    mechanics/trajectory/trajectory.hpp
    mechanics/results/body_poses.hpp
    mechanics/results/metrics.hpp
    mechanics/results/quantities.hpp
    mechanics/results/result.hpp
    mechanics/dynamics/dynamic_parameters.hpp
    mechanics/dynamics/inverse_dynamics.hpp
    motion/study/study.hpp
    motion/simulation/simulate.hpp)
set(balance_public_derivatives mechanics/derivatives/mechanism_variables.hpp mechanics/derivatives/state_gradient.hpp)
set(balance_public_files
    interface/specification/balanced_spec.hpp
    interface/specification/read_spec.hpp
    interface/files/result_file.hpp
    interface/files/result_summary.hpp)
set(balance_public_synthesis
    motion/control/closed_loop_run.hpp
    synthesis/conditions/condition_text.hpp
    synthesis/conditions/conditions.hpp
    synthesis/conditions/modular_conditions.hpp
    synthesis/verification/formulation_check.hpp
    synthesis/verification/mechanism_check.hpp
    synthesis/tolerance/robust_figure.hpp
    synthesis/design/design_study.hpp
    synthesis/design/spec_figure_gradients.hpp)
set(balance_public_interface
    interface/comparison/comparison.hpp
    interface/comparison/requirement.hpp
    interface/comparison/requirement_verdict.hpp
    interface/import/import.hpp
    interface/import/mass_export.hpp
    interface/import/robot_export.hpp
    interface/reports/html_report.hpp)

set(balance_umbrella
    "#pragma once\n/// Everything that users of the library include; <balance/…> of their own are in the same place.\n")
set(balance_installed_headers "")
foreach(part core derivatives files synthesis interface)
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
