# The library's parts. Each is made of rooms (folders of lib/balance) and stands on the parts before it, so that whoever wants
# dynamics alone needs Eigen alone. scripts/check_layers watches the rooms' order.

# balance_part(<part> ROOMS <room>… [STANDS_ON <part>…] [LINK <foreign library>…])
function(balance_part part)
  cmake_parse_arguments(PARSE_ARGV 1 given "" "" "ROOMS;STANDS_ON;LINK")
  set(sources "")
  foreach(room IN LISTS given_ROOMS)
    file(GLOB_RECURSE found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/lib/balance/${room}/*.cpp)
    list(APPEND sources ${found})
  endforeach()
  list(FILTER sources EXCLUDE REGEX "/lanes/kernels\\.cpp$") # by balance_compile_lanes
  set(target balance_${part})
  add_library(${target} STATIC ${sources})
  add_library(balance::${part} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${part})
  set_property(GLOBAL APPEND PROPERTY balance_foreign_libraries ${given_LINK})
  list(TRANSFORM given_STANDS_ON PREPEND balance_)
  target_link_libraries(${target} PUBLIC ${given_STANDS_ON} PRIVATE ${given_LINK})
  balance_compile_options(${target})
  balance_harden(${target})
  balance_count_lines(${target})
  balance_compile_together(${target})
  set_property(GLOBAL APPEND PROPERTY balance_parts ${target})
endfunction()

# The long ones stay alone, so that two processors share them.
set_source_files_properties(
  lib/balance/base/factorizations.cpp lib/balance/base/factorizations_svd.cpp lib/balance/conditions/factorizations.cpp
  lib/balance/conditions/farkas_cone.cpp
  PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)

balance_part(core ROOMS base expression model kinematics motion dynamics lanes natural result inverse equations timing simulation study)
target_link_libraries(balance_core PUBLIC Eigen3::Eigen)
target_compile_features(balance_core PUBLIC cxx_std_20)
target_include_directories(
  balance_core PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/lib> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/generated>
                      $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
# Three-vectors and 3×3 matrices written in pairs and read one by one (or the other way round) stall the processor's store
# buffer: without this the recursions take a third longer.
target_compile_definitions(balance_core PUBLIC EIGEN_UNALIGNED_VECTORIZE=0 PRIVATE ${balance_lane_definitions})
balance_compile_lanes(balance_core balance_lanes lib/balance/lanes/kernels.cpp lib/balance/motion/equations.cpp)

# The engine over numbers with derivatives: these sources of templates once more, see base/number.hpp.
add_library(balance_duals OBJECT
  lib/balance/model/coupling_roots.cpp
  lib/balance/kinematics/joint_coordinates.cpp lib/balance/kinematics/joint_steps.cpp
  lib/balance/kinematics/rate_closures.cpp lib/balance/kinematics/tree.cpp
  lib/balance/motion/drive_rows.cpp lib/balance/motion/equations.cpp lib/balance/motion/equations_singular.cpp
  lib/balance/dynamics/actuation.cpp lib/balance/dynamics/actuation_matrix.cpp lib/balance/dynamics/external.cpp lib/balance/dynamics/observer.cpp)
target_link_libraries(balance_duals PRIVATE balance_core)
target_compile_definitions(balance_duals PRIVATE BALANCE_DUALS)
balance_compile_options(balance_duals)
balance_harden(balance_duals)
balance_part(gradients ROOMS gradients STANDS_ON core)
balance_part(formulas ROOMS formulas STANDS_ON core)
target_sources(balance_gradients PRIVATE $<TARGET_OBJECTS:balance_duals>)

balance_part(reading ROOMS hdf5 spec STANDS_ON core
             LINK yaml-cpp hdf5::hdf5 hdf5::hdf5_hl fmt::fmt ZLIB::ZLIB)
balance_optimise_little(balance_reading)
balance_part(writing ROOMS write STANDS_ON reading LINK fmt::fmt nlohmann_json::nlohmann_json OpenSSL::Crypto)
if(NOT BALANCE_SIMULATE_ONLY)
  balance_part(design ROOMS control conditions design cost analysis STANDS_ON core gradients LINK fmt::fmt PkgConfig::nlopt PkgConfig::clp)
  target_include_directories(balance_design SYSTEM PRIVATE ${Boost_INCLUDE_DIRS}) # headers only: Odeint
  balance_part(comparing ROOMS compare read present answers batch STANDS_ON design writing formulas LINK fmt::fmt nlohmann_json::nlohmann_json)
  balance_optimise_little(balance_comparing)
  balance_part(importing ROOMS import STANDS_ON design reading LINK fmt::fmt pugixml::pugixml)
  balance_optimise_little(balance_importing)
  balance_part(pages ROOMS report STANDS_ON comparing LINK fmt::fmt nlohmann_json::nlohmann_json)
  balance_optimise_little(balance_pages)
endif()

# All there are.
get_property(balance_parts GLOBAL PROPERTY balance_parts)
get_property(balance_foreign_libraries GLOBAL PROPERTY balance_foreign_libraries)
list(REMOVE_DUPLICATES balance_foreign_libraries)
add_library(balance INTERFACE)
add_library(balance::balance ALIAS balance)
target_link_libraries(balance INTERFACE ${balance_parts})
