#pragma once
/// Runs a printed program by reading its statements, so that what is printed is what is tested. Private to formulas.

#include "balance/formulas/code.hpp"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace balance::formulas {

class ProgramInterpreter {
 public:
  /// @throws FormulaError where it has no statements that can be read
  ProgramInterpreter(const std::string& text, Language language, std::size_t columns);

  /// One of the mechanism's numbers, under the name that its symbol has. One that the program does not use is ignored.
  void set_parameter(const std::string& name, double value);
  /// To be called after numbers have been set.
  void prepare() { execute(prepare_statements_); }
  std::vector<double> compute_torques(const std::vector<double>& q, const std::vector<double>& dq,
                                      const std::vector<double>& ddq);

 private:
  using Statements = std::vector<std::pair<std::string, std::string>>;  ///< target, expression
  void execute(const Statements& statements);
  void set_array(const char* list, const std::vector<double>& values);

  bool is_c_;
  std::size_t columns_;
  Statements prepare_statements_, torque_statements_;
  std::map<std::string, double> values_;  ///< by name as the program writes it: `p->l1`, `k[3]`
};

}  // namespace balance::formulas
