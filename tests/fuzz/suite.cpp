#include "balance/read/suite.hpp"
#include "balance/spec/named_files.hpp"

#include "targets.hpp"

namespace balance::fuzz {

void suite(std::string_view bytes) {
  const std::string text(bytes);
  complains_well([&] { parse_suite(text, "suite.yaml"); });
  list_referenced_files(text, "suite.yaml");
}

}  // namespace balance::fuzz
