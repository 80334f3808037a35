#include "balance/import/names.hpp"

#include "balance/base/plain_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace balance::foreign {

namespace {

constexpr std::size_t max_name_bytes = 200;  // bytes; YAML knows no keys of more than 1024

}  // namespace

std::string sanitise_name(const std::string& wanted) {
  std::string name;
  for (std::size_t i = 0; i < wanted.size() && name.size() < max_name_bytes;) {
    const std::size_t bytes = std::max<std::size_t>(1, decode_utf8(std::string_view(wanted).substr(i)).bytes);
    const std::string character = wanted.substr(i, bytes);
    name += is_unicode_identifier("a" + character) ? character : "_";
    i += bytes;
  }
  if (name.empty()) return "unnamed";
  if (!is_unicode_identifier(name)) name.insert(0, "n");
  // what YAML 1.1 takes for something else than text
  static constexpr std::array<std::string_view, 9> yaml_reserved_words{"y",   "n",    "yes",   "no",  "on",
                                                                       "off", "true", "false", "null"};
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return std::find(yaml_reserved_words.begin(), yaml_reserved_words.end(), lower) == yaml_reserved_words.end()
             ? name
             : name + "_";
}

std::string NameAllocator::allocate(const std::string& wanted) {
  const std::string name = sanitise_name(wanted);
  std::string unique = name;
  int& next = next_.try_emplace(name, 2).first->second;
  while (!taken_.insert(unique).second) unique = fmt::format("{}_{}", name, next++);
  return unique;
}

}  // namespace balance::foreign
