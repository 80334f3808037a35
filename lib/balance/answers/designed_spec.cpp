#include "balance/answers/designed_spec.hpp"

#include "balance/base/error.hpp"
#include "balance/present/chosen.hpp"
#include "balance/present/load_cases_text.hpp"
#include "balance/spec/read_spec.hpp"
#include "balance/write/balanced_spec.hpp"

namespace balance {

std::string designed_spec(const DesignSpace& space, const DesignReport& report) {
  const std::vector<std::string> laws = law_expressions(report);
  const std::vector<OfferedElement> gaps = left_out(report);
  const std::string whole = balanced_spec(space.start, report.outcome.x, laws);
  if (gaps.empty()) return whole;
  const std::string without = balanced_spec(space.start, report.outcome.x, laws, gaps);
  try {
    read_spec(without, space.start.spec_file);
    return without;
  } catch (const SpecError&) {
    return whole;
  }
}

}  // namespace balance
