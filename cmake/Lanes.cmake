# What is compiled once for every instruction set of x86-64 and chosen when the program runs. Everything else is for the baseline
# (SSE2) alone, and so is all where another processor or a sanitizer is at work.
set(balance_instruction_sets baseline)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$" AND CMAKE_OBJCOPY AND NOT BALANCE_SANITIZE AND NOT BALANCE_COVERAGE)
  list(APPEND balance_instruction_sets avx2 avx512)
endif()
# For sources that ask whether there is an object for a set.
list(TRANSFORM balance_instruction_sets PREPEND BALANCE_LANES_ OUTPUT_VARIABLE balance_lane_definitions)

# Lanes keep to IEEE 754, and no product is fused with a sum: every set gives the same bits. Loops over lanes are written for them.
set(balance_lane_flags -ffp-contract=off -fno-math-errno -fno-trapping-math -fno-tree-vectorize)
if(NOT BALANCE_SANITIZE)
  list(APPEND balance_lane_flags -O3)
endif()
set(balance_flags_of_baseline "")
set(balance_flags_of_avx2 -mavx2)
set(balance_flags_of_avx512 -mavx512f -mavx512dq -mavx512vl -mprefer-vector-width=512)

# balance_compile_lanes(<target> <table> <source>…): adds the sources to the target, compiled for every instruction set.
# BALANCE_LANES_TABLE names the only symbol that an object shows, the variable <table>_<set> with C's linkage. Inline functions and
# templates of an object are its own: if they were shared, as the linker shares what has the same name, the baseline might be given
# code that its machine does not have.
function(balance_compile_lanes target table)
  foreach(set IN LISTS balance_instruction_sets)
    set(part ${target}_lanes_${set})
    add_library(${part} OBJECT ${ARGN})
    target_include_directories(${part} PRIVATE $<TARGET_PROPERTY:balance_core,INTERFACE_INCLUDE_DIRECTORIES>)
    target_link_libraries(${part} PRIVATE Eigen3::Eigen)
    target_compile_definitions(${part} PRIVATE $<TARGET_PROPERTY:balance_core,INTERFACE_COMPILE_DEFINITIONS>
                                               BALANCE_LANES_TABLE=${table}_${set})
    balance_compile_options(${part})
    balance_harden(${part})
    target_compile_options(${part} PRIVATE ${balance_lane_flags} ${balance_flags_of_${set}})
    if(set STREQUAL "baseline")
      balance_count_lines(${part})
      target_sources(${target} PRIVATE $<TARGET_OBJECTS:${part}>)
      continue()
    endif()
    # Values pass between the sets: Eigen lays them out as for SSE2.
    target_compile_definitions(${part} PRIVATE EIGEN_DONT_VECTORIZE EIGEN_MAX_STATIC_ALIGN_BYTES=16)
    set(object ${CMAKE_CURRENT_BINARY_DIR}/${part}.o)
    add_custom_command(
      OUTPUT ${object}
      COMMAND ${CMAKE_LINKER} -r --force-group-allocation -o ${object}.linked $<TARGET_OBJECTS:${part}>
      COMMAND ${CMAKE_OBJCOPY} --keep-global-symbol=${table}_${set} ${object}.linked ${object}
      DEPENDS $<TARGET_OBJECTS:${part}>
      COMMENT "${table} for ${set}"
      VERBATIM COMMAND_EXPAND_LISTS)
    set_source_files_properties(${object} PROPERTIES EXTERNAL_OBJECT ON GENERATED ON)
    target_sources(${target} PRIVATE ${object})
    set_property(GLOBAL APPEND PROPERTY balance_lane_objects ${object})
  endforeach()
endfunction()
