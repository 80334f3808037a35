#include "targets.hpp"

#include <cstdio>
#include <cstdlib>
#include <utility>

namespace balance::fuzz {

Target find_target(std::string_view name) {
  constexpr std::pair<std::string_view, Target> all[] = {
      {"chrono", chrono},           {"csv", csv},   {"hdf5", hdf5},   {"loops", loops}, {"mbse", mbse}, {"mjcf", mjcf},
      {"requirement", requirement}, {"spec", spec}, {"suite", suite}, {"urdf", urdf}};
  for (const auto& [known, target] : all)
    if (known == name) return target;
  return nullptr;
}

void demand(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

bool names_a_place(const SourceLocation& place) {
  const bool known = place.file.ends_with(".yaml") || place.file.ends_with(".urdf") || place.file.ends_with(".xml");
  return place.is_option() || (known && place.line > 0 && place.column > 0);
}

}  // namespace balance::fuzz
