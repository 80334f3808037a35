# A room's sources compiled several at a time: reading headers takes half the compiler's time in a clean build. It costs
# time in daily work, where one source changes, and asks that names in unnamed namespaces differ within a room.
option(BALANCE_UNITY "Compile several sources of a room at a time" OFF)

# Sources of one folder come together, at most that many at a time.
function(balance_compile_together target most)
  if(NOT BALANCE_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    cmake_path(GET source PARENT_PATH room)
    cmake_path(GET room FILENAME room)
    math(EXPR count_${room} "0${count_${room}} + 1")
    math(EXPR part "(${count_${room}} - 1) / ${most}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${room}${part}")
  endforeach()
  # What is in an unnamed namespace of an included source seems to GCC to be in a header.
  target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
