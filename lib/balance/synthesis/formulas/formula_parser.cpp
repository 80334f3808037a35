#include "balance/synthesis/formulas/formula_parser.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <cmath>
#include <cstdlib>
#include <sstream>

namespace balance::formulas {

namespace {

struct StatementEvaluator {
  const std::map<std::string, double>& values;

  static double number(const std::string& text) { return std::strtod(text.c_str(), nullptr); }
  double name(const std::string& name) const {
    const auto known = values.find(name);
    if (known == values.end()) throw FormulaError("the program uses " + name + " before it has a value");
    return known->second;
  }
  static std::string strip_math_prefix(const std::string& name) {
    return name.starts_with("math.") ? name.substr(5) : name;
  }
  static bool is_function(const std::string& name) {
    return strip_math_prefix(name) == "sin" || strip_math_prefix(name) == "cos" || strip_math_prefix(name) == "sqrt";
  }
  static double call(const std::string& function, double x) {
    const std::string name = strip_math_prefix(function);
    return name == "sin" ? elementary::sin(x) : name == "cos" ? elementary::cos(x) : std::sqrt(x);
  }
  static double power(double, int) { throw FormulaError("neither C nor Python writes powers so"); }
  static double quotient(double a, double b) { return a / b; }
};

std::string strip_affixes(std::string text, const std::string& begin, const std::string& end) {
  if (text.starts_with(begin)) text.erase(0, begin.size());
  if (text.ends_with(end)) text.resize(text.size() - end.size());
  return text;
}

}  // namespace

ProgramInterpreter::ProgramInterpreter(const std::string& text, Language language, std::size_t columns)
    : is_c_(language == Language::c), columns_(columns) {
  Statements* function = nullptr;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(is_c_ ? "static void prepare(" : "def prepare("))
      function = &prepare_statements_;
    else if (line.starts_with(is_c_ ? "static void torques(" : "def torques("))
      function = &torque_statements_;
    else if (!line.empty() && line[0] != ' ')
      function = nullptr;
    const std::size_t equals_sign = line.find(" = ");
    const bool is_list = equals_sign != std::string::npos && line[equals_sign + 3] == '[';
    if (function == nullptr || equals_sign == std::string::npos || is_list) continue;
    const std::size_t begin = line.find_first_not_of(' ');
    function->emplace_back(strip_affixes(line.substr(begin, equals_sign - begin), "const double ", ""),
                           strip_affixes(line.substr(equals_sign + 3), "", ";"));
  }
  if (torque_statements_.empty()) throw FormulaError("the program has no statements");
}

void ProgramInterpreter::set_parameter(const std::string& name, double value) {
  values_[is_c_ ? "p->" + c_member_name(name) : "p[\"" + name + "\"]"] = value;
}

void ProgramInterpreter::execute(const Statements& statements) {
  StatementEvaluator factory{values_};
  for (const auto& [target, expression] : statements)
    values_[target] = FormulaParser<double, StatementEvaluator>(expression, factory).read();
}

void ProgramInterpreter::set_array(const char* list, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    values_[std::string(list) + "[" + std::to_string(i) + "]"] = values[i];
}

std::vector<double> ProgramInterpreter::compute_torques(const std::vector<double>& q, const std::vector<double>& dq,
                                                        const std::vector<double>& ddq) {
  set_array("q", q), set_array("dq", dq), set_array("ddq", ddq);
  execute(torque_statements_);
  std::vector<double> torques;
  for (std::size_t i = 0; i < columns_; ++i) torques.push_back(values_.at("tau[" + std::to_string(i) + "]"));
  return torques;
}

namespace {

struct ValueFactory {
  const std::map<std::string, double>& values;

  static double number(const std::string& text) { return std::strtod(text.c_str(), nullptr); }
  double name(const std::string& name) const {
    const auto known = values.find(name);
    if (known == values.end()) throw FormulaError(name + " has no value");
    return known->second;
  }
  static bool is_function(const std::string& name) { return name == "sin" || name == "cos" || name == "sqrt"; }
  static double call(const std::string& function, double x) {
    return function == "sin" ? elementary::sin(x) : function == "cos" ? elementary::cos(x) : std::sqrt(x);
  }
  static double power(double base, int exponent) { return elementary::pow(base, exponent); }
  static double quotient(double a, double b) { return a / b; }
};

}  // namespace

double evaluate_text(const std::string& text, const std::map<std::string, double>& values) {
  ValueFactory factory{values};
  return FormulaParser<double, ValueFactory>(text, factory).read();
}

}  // namespace balance::formulas
