# One place for what the compiler is told. No -march=native: a binary runs on every machine of its architecture.

set(balance_warnings
    -Wall
    -Wextra
    -Wpedantic
    -Wshadow=local # in one go with others, a source sees the names that these keep to themselves
    -Wnon-virtual-dtor
    -Woverloaded-virtual
    -Wcast-qual
    -Wunused
    -Wfloat-conversion
    -Wduplicated-cond
    -Wlogical-op
    -Wextra-semi
    -Wno-psabi # vectors wider than the baseline's registers stay inside an object
    -Wno-missing-field-initializers # structs are filled by name, and what is left out has its default
    # GCC 12 warns wrongly about concatenated std::strings (GCC bugs 105651, 105329)
    -Wno-restrict
    -Wno-array-bounds
    -Wno-stringop-overflow
    -Wno-stringop-overread)
# -Wconversion is only taken in its floating-point part: Eigen's signed indices and the standard library's unsigned
# sizes meet on every page, and a cast at each meeting hides more than it shows.

function(balance_compile_options target)
  if(BALANCE_STRICT)
    target_compile_options(${target} PRIVATE ${balance_warnings} -Werror)
  else()
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wno-missing-field-initializers -Wno-restrict -Wno-psabi)
  endif()
  if(BALANCE_SANITIZE)
    # What -fno-sanitize leaves out takes a quarter of the compiler's time on Eigen, and the address sanitizer sees it too.
    # Checks that are called instead of written out take another quarter less.
    target_compile_definitions(${target} PRIVATE BALANCE_SANITIZED)
    target_compile_options(${target} PRIVATE -fsanitize=${BALANCE_SANITIZE} -fno-sanitize-recover=all
                                             -fno-sanitize=null,alignment,vptr,object-size,pointer-overflow
                                             -fno-omit-frame-pointer)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE --param asan-instrumentation-with-call-threshold=0)
    endif()
    target_link_options(${target} PRIVATE -fsanitize=${BALANCE_SANITIZE})
  endif()
endfunction()

# What makes mistakes in memory hard to exploit. FORTIFY needs an optimiser; sanitizers do its work better.
function(balance_harden target)
  # Position independent, yet as free to inline as if nobody could replace a function when the program is loaded.
  target_compile_options(${target} PRIVATE -fstack-protector-strong $<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>)
  if(NOT BALANCE_SANITIZE)
    target_compile_options(${target} PRIVATE "$<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2>")
  endif()
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "EXECUTABLE")
    target_link_options(${target} PRIVATE LINKER:-z,relro,-z,now)
  endif()
endfunction()

function(balance_count_lines target)
  if(BALANCE_COVERAGE)
    target_compile_definitions(${target} PRIVATE BALANCE_COVERAGE)
    target_compile_options(${target} PRIVATE --coverage)
    target_link_options(${target} PUBLIC --coverage)
  endif()
endfunction()

# For what runs once: optimising it takes longer than it saves.
function(balance_optimise_little target)
  if(NOT BALANCE_SANITIZE)
    target_compile_options(${target} PRIVATE -O1)
  endif()
endfunction()
