# The library's parts. Each is made of rooms (folders of lib/balance) and stands on the parts before it, so a program that wants
# dynamics alone needs Eigen alone. scripts/check_layers watches the rooms' order.

# balance_part(<part> ROOMS <room>… [STANDS_ON <part>…] [LINK <foreign library>…])
function(balance_part part)
  cmake_parse_arguments(PARSE_ARGV 1 given "" "" "ROOMS;STANDS_ON;LINK")
  set(sources "")
  foreach(room IN LISTS given_ROOMS)
    file(GLOB_RECURSE found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/lib/balance/${room}/*.cpp)
    list(APPEND sources ${found})
  endforeach()
  # The first by balance_compile_lanes, the second where Clp is.
  list(FILTER sources EXCLUDE REGEX "/lane_kernels\\.cpp$|/linear_program\\.cpp$")
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

set(balance_clp_seam lib/balance/foundation/numerics/linear_program.cpp)

# The long ones stay alone, so that two processors share them.
set_source_files_properties(
  lib/balance/foundation/numerics/eigen_instantiations.cpp lib/balance/foundation/numerics/eigen_instantiations_svd.cpp
  lib/balance/foundation/numerics/right_singular_vectors.cpp lib/balance/synthesis/conditions/farkas_certificates.cpp
  lib/balance/synthesis/design/catalogue_program.cpp lib/balance/synthesis/design/catalogue_search.cpp
  lib/balance/synthesis/design/length_ratio_bound.cpp
  PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)

balance_part(core
  ROOMS foundation/base foundation/numerics foundation/expression mechanics/model mechanics/trajectory mechanics/results
        mechanics/kinematics mechanics/dynamics mechanics/lanes motion/study motion/time_optimal motion/simulation motion/vibration)
target_link_libraries(balance_core PUBLIC Eigen3::Eigen)
target_compile_features(balance_core PUBLIC cxx_std_20)
target_include_directories(
  balance_core PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/lib> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/generated>
                      $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
# Three-vectors and 3×3 matrices written in pairs and read one by one (or the other way round) stall the processor's store
# buffer: without this the recursions take a third longer.
target_compile_definitions(balance_core PUBLIC EIGEN_UNALIGNED_VECTORIZE=0 PRIVATE ${balance_lane_definitions})
balance_compile_lanes(balance_core balance_lanes lib/balance/mechanics/lanes/lane_kernels.cpp
                      lib/balance/mechanics/kinematics/kinematic_equations.cpp)

# What a sanitizer need not see can come from a build of the same sources that stands ready.
set(BALANCE_BUILT_SYNTHESIS "" CACHE PATH "Folder of a release build with the libraries of derivatives and synthesis; empty: they are built here")
function(balance_take_built part)
  add_library(balance_${part} STATIC IMPORTED GLOBAL)
  set(links ${ARGN})
  list(TRANSFORM links PREPEND balance_ REGEX "^(core|derivatives)$")
  set_target_properties(balance_${part} PROPERTIES IMPORTED_LOCATION ${BALANCE_BUILT_SYNTHESIS}/libbalance_${part}.a
                                                   INTERFACE_LINK_LIBRARIES "${links}")
  set_property(GLOBAL APPEND PROPERTY balance_parts balance_${part})
endfunction()

if(BALANCE_BUILT_SYNTHESIS)
  # Matrices pass between both builds, and GCC's address sanitizer makes Eigen allocate in another way than that one did.
  target_compile_definitions(balance_core PUBLIC EIGEN_MALLOC_ALREADY_ALIGNED=1)
  balance_take_built(derivatives core)
else()
  # The engine over dual numbers: these sources of templates once more, see numerics/engine_scalar.hpp.
  add_library(balance_duals OBJECT
    lib/balance/mechanics/model/couplings.cpp
    lib/balance/mechanics/kinematics/drive.cpp lib/balance/mechanics/kinematics/joint_coordinates.cpp
    lib/balance/mechanics/kinematics/kinematic_equations.cpp lib/balance/mechanics/kinematics/kinematic_equations_singular.cpp
    lib/balance/mechanics/kinematics/tree.cpp
    lib/balance/mechanics/dynamics/actuation.cpp lib/balance/mechanics/dynamics/external_forces.cpp
    lib/balance/mechanics/dynamics/sample_evaluator.cpp)
  target_link_libraries(balance_duals PRIVATE balance_core)
  target_compile_definitions(balance_duals PRIVATE BALANCE_DUALS)
  balance_compile_options(balance_duals)
  balance_harden(balance_duals)
  balance_part(derivatives ROOMS mechanics/derivatives STANDS_ON core)
  target_sources(balance_derivatives PRIVATE $<TARGET_OBJECTS:balance_duals>)

  # The same over interval jets, for bounds over boxes of lengths.
  add_library(balance_intervals OBJECT
    lib/balance/mechanics/model/couplings.cpp lib/balance/mechanics/kinematics/tree.cpp)
  target_link_libraries(balance_intervals PRIVATE balance_core)
  target_compile_definitions(balance_intervals PRIVATE BALANCE_INTERVALS)
  balance_compile_options(balance_intervals)
  balance_harden(balance_intervals)
endif()

balance_part(files ROOMS foundation/hdf5 interface/specification interface/files STANDS_ON core
             LINK yaml-cpp hdf5::hdf5 hdf5::hdf5_hl fmt::fmt nlohmann_json::nlohmann_json OpenSSL::Crypto ZLIB::ZLIB)
balance_optimise_little(balance_files)

if(BALANCE_BUILT_SYNTHESIS)
  balance_take_built(synthesis derivatives core fmt::fmt PkgConfig::nlopt PkgConfig::clp)
else()
  balance_part(synthesis
    ROOMS motion/control synthesis/conditions synthesis/verification synthesis/formulas synthesis/tolerance synthesis/certificate synthesis/design synthesis/identification
    STANDS_ON core derivatives LINK fmt::fmt PkgConfig::nlopt PkgConfig::clp)
  target_sources(balance_synthesis PRIVATE ${balance_clp_seam} $<TARGET_OBJECTS:balance_intervals>)
  target_include_directories(balance_synthesis SYSTEM PRIVATE ${Boost_INCLUDE_DIRS}) # headers only: Odeint
endif()

balance_part(interface ROOMS interface/comparison interface/import interface/reports interface/batch STANDS_ON synthesis files
             LINK fmt::fmt nlohmann_json::nlohmann_json pugixml::pugixml)
balance_optimise_little(balance_interface)

# All there are.
get_property(balance_parts GLOBAL PROPERTY balance_parts)
get_property(balance_foreign_libraries GLOBAL PROPERTY balance_foreign_libraries)
list(REMOVE_DUPLICATES balance_foreign_libraries)
add_library(balance INTERFACE)
add_library(balance::balance ALIAS balance)
target_link_libraries(balance INTERFACE ${balance_parts})
