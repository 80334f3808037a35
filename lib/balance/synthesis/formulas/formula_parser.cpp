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
  const std::string head = is_c_ ? "static void " : "def ";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(head) && line.find('(') != std::string::npos)
      function = &functions_[line.substr(head.size(), line.find('(') - head.size())];
    else if (!line.empty() && line[0] != ' ')
      function = nullptr;
    const std::size_t equals_sign = line.find(" = ");
    const bool is_list = equals_sign != std::string::npos && line[equals_sign + 3] == '[';
    if (function == nullptr || equals_sign == std::string::npos || is_list) continue;
    const std::size_t begin = line.find_first_not_of(' ');
    function->emplace_back(strip_affixes(line.substr(begin, equals_sign - begin), "const double ", ""),
                           strip_affixes(line.substr(equals_sign + 3), "", ";"));
  }
  if (functions_["torques"].empty() && functions_["tree_torques"].empty())
    throw FormulaError("the program has no statements");
}

void ProgramInterpreter::set_parameter(const std::string& name, double value) {
  values_[is_c_ ? "p->" + c_member_name(name) : "p[\"" + name + "\"]"] = value;
}

void ProgramInterpreter::execute(const Statements& statements) {
  StatementEvaluator factory{values_};
  for (const auto& [target, expression] : statements)
    values_[target] = FormulaParser<double, StatementEvaluator>(expression, factory).read();
}

std::vector<std::vector<double>> ProgramInterpreter::call(
    const std::string& function, const std::map<std::string, std::vector<double>>& arguments,
    const std::vector<std::pair<std::string, std::size_t>>& results) {
  const auto element = [](const std::string& list, std::size_t i) { return list + "[" + std::to_string(i) + "]"; };
  for (const auto& [list, values] : arguments)
    for (std::size_t i = 0; i < values.size(); ++i) values_[element(list, i)] = values[i];
  execute(functions_.at(function));
  std::vector<std::vector<double>> found;
  for (const auto& [list, size] : results) {
    found.emplace_back();
    for (std::size_t i = 0; i < size; ++i) found.back().push_back(values_.at(element(list, i)));
  }
  return found;
}

std::vector<double> ProgramInterpreter::compute_torques(const std::vector<double>& q, const std::vector<double>& dq,
                                                        const std::vector<double>& ddq) {
  const char* function = functions_["tree_torques"].empty() ? "torques" : "tree_torques";
  return call(function, {{"q", q}, {"dq", dq}, {"ddq", ddq}}, {{"tau", columns_}})[0];
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
