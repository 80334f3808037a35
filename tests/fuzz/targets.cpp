#include "targets.hpp"

#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace balance::fuzz {

Target find_target(std::string_view name) {
  constexpr std::pair<std::string_view, Target> all[] = {
      {"csv", csv}, {"hdf5", hdf5}, {"requirement", requirement}, {"spec", spec}, {"suite", suite}};
  for (const auto& [known, target] : all)
    if (known == name) return target;
  return nullptr;
}

void demand(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

bool names_a_place(const std::string& message) {
  if (message.starts_with("--")) return true;
  const auto number = [&](std::size_t& at) {
    const std::size_t begin = at;
    while (at < message.size() && std::isdigit(static_cast<unsigned char>(message[at])) != 0) ++at;
    return at > begin && at < message.size() && message[at++] == ':';
  };
  std::size_t at = message.find(".yaml:");
  if (at == std::string::npos) return false;
  at += 6;
  return number(at) && number(at) && at < message.size() && message[at] == ' ';
}

}  // namespace balance::fuzz
