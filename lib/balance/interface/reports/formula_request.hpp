#pragma once
/// Equations of motion as formulas or as a program, from the request to what is printed: for the command and for Python.

#include "balance/interface/reports/balance_request.hpp"
#include "balance/interface/reports/formulas_sections.hpp"
#include "balance/interface/reports/report_data.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/formulas/program_code.hpp"

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::reports {

/// A request that cannot be meant. The sentence begins with what is wrong: `--solve: 'x' is neither …`.
class FormulaRequestError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

struct FormulaRequest {
  std::vector<std::string> only;         ///< names of sections; empty: all that the mechanism has
  bool expand = false;                   ///< replaces parameters that depend on others by their expressions
  bool with_values = false;              ///< numbers in place of symbols
  bool all = false;                      ///< sections of any length
  bool latex = false;                    ///< LaTeX, too
  std::vector<std::string> independent;  ///< names of coordinates; empty: a choice
  std::vector<std::string> solve;        ///< numbers for which the conditions are solved
  std::vector<std::string> collect;      ///< symbols by whose powers sums are grouped
  std::string speeds;                    ///< `v: tool.u, w: A`; empty: those of the spec
  /// Goals, strategy and what the goals exclude, for `solve`.
  std::function<BalanceRequest(const Study&)> balance;
  std::string prefix = "--";  ///< of the names in messages
};

/// Formulas that have been checked against the engine, or why there are none.
struct DerivedFormulas {
  RequestFailure refusal;
  std::unique_ptr<formulas::FormulaSheet> sheet;  ///< what `view` refers to
  FormulasReportData view, latex;
};

/// @param text, file, read of the spec
/// @throws SpecError; FormulaRequestError; what `balance` throws
DerivedFormulas derive_formulas(const FormulaRequest& request, const std::string& text, const std::string& file,
                                const ReadOptions& read);

struct GeneratedProgram {
  RequestFailure refusal;
  std::string code;
  std::vector<std::string> warnings;  ///< of the spec
};

/// @param coordinates `independent` or `all`
/// @throws as derive_formulas
GeneratedProgram generate_program_of(const FormulaRequest& request, formulas::Language language,
                                     formulas::ProgramCoordinates coordinates, const std::string& text,
                                     const std::string& file, const ReadOptions& read);

}  // namespace balance::reports
