# A room's sources compiled as one: reading headers takes half the compiler's time in a clean build. It costs
# time in daily work, where one source changes, and asks that names in unnamed namespaces differ within a room.
option(BALANCE_UNITY "Compile the sources of a room together" OFF)
set(BALANCE_UNITY_EXCEPT "" CACHE STRING "Rooms whose sources are compiled one by one all the same, those one works on: specification;formulas")

# Sources of one folder come together.
function(balance_compile_together target)
  if(NOT BALANCE_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    cmake_path(GET source PARENT_PATH room)
    cmake_path(GET room FILENAME room)
    if(room IN_LIST BALANCE_UNITY_EXCEPT)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # What is in an unnamed namespace of an included source seems to GCC to be in a header.
  target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
endfunction()

# So many sources of a target come together, in the order of their names: fewer to compile again where one of them changes.
function(balance_compile_in_batches target size)
  if(BALANCE_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE BATCH UNITY_BUILD_BATCH_SIZE ${size})
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()
