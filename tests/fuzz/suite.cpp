#include "balance/interface/batch/suite.hpp"
#include "balance/interface/specification/include_expansion.hpp"

#include "targets.hpp"

namespace balance::fuzz {

void suite(std::string_view bytes) {
  const std::string text(bytes);
  complains_well([&] { batch::parse_suite(text, "suite.yaml"); });
  specification::list_referenced_files(text, "suite.yaml");
}

}  // namespace balance::fuzz
