# The specs that `balance new` prints, in the order of its list: configs/starters/<kind>.yaml becomes text in the program.
set(balance_starters arm four-bar slider-crank 5r 3rrr spatial-arm delta)

function(balance_embed_starters target)
  set(entries "")
  foreach(kind IN LISTS balance_starters)
    set(spec ${PROJECT_SOURCE_DIR}/configs/starters/${kind}.yaml)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${spec})
    file(READ ${spec} text)
    string(APPEND entries "      {\"${kind}\", R\"spec(${text})spec\"},\n")
  endforeach()
  set(source ${CMAKE_CURRENT_BINARY_DIR}/generated/starters.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT [[
#include "starters.hpp"

namespace balance::app {

const std::vector<Starter>& starters() {
  static const std::vector<Starter> all = {
@entries@  };
  return all;
}

}  // namespace balance::app
]] @ONLY)
  target_sources(${target} PRIVATE ${source})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/app)
endfunction()
