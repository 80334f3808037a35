#pragma once
/// `balance equations` without a pose: closed formulas.

#include "command.hpp"

#include <string>
#include <vector>

namespace balance::app {

struct FormulaOptions {
  SpecOptions spec;
  std::vector<std::string> only;
  std::string code;  ///< `c` or `python`; empty: formulas
  bool latex = false, numbers = false, expand = false, all = false;
};

/// @throws UsageError for sections that there are not
ExitCode print_formulas(const FormulaOptions& options);

}  // namespace balance::app
