#include "balance/formulas/printed_program.hpp"

#include "balance/base/elementary.hpp"
#include "balance/formulas/expression.hpp"

#include <cmath>
#include <cstdlib>
#include <sstream>

namespace balance::formulas {

namespace {

struct StatementMaker {
  const std::map<std::string, double>& values;

  static double number(const std::string& text) { return std::strtod(text.c_str(), nullptr); }
  double name(const std::string& name) const {
    const auto known = values.find(name);
    if (known == values.end()) throw FormulaError("the program uses " + name + " before it has a value");
    return known->second;
  }
  static std::string plain(const std::string& name) { return name.starts_with("math.") ? name.substr(5) : name; }
  static bool is_function(const std::string& name) {
    return plain(name) == "sin" || plain(name) == "cos" || plain(name) == "sqrt";
  }
  static double call(const std::string& function, double x) {
    const std::string name = plain(function);
    return name == "sin" ? elementary::sin(x) : name == "cos" ? elementary::cos(x) : std::sqrt(x);
  }
  static double power(double, int) { throw FormulaError("neither C nor Python writes powers so"); }
  static double quotient(double a, double b) { return a / b; }
};

std::string without_ends(std::string text, const std::string& begin, const std::string& end) {
  if (text.starts_with(begin)) text.erase(0, begin.size());
  if (text.ends_with(end)) text.resize(text.size() - end.size());
  return text;
}

}  // namespace

PrintedProgram::PrintedProgram(const std::string& text, Language language, std::size_t columns)
    : c_(language == Language::c), columns_(columns) {
  Statements* function = nullptr;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(c_ ? "static void prepare(" : "def prepare("))
      function = &prepare_;
    else if (line.starts_with(c_ ? "static void torques(" : "def torques("))
      function = &torques_;
    else if (!line.empty() && line[0] != ' ')
      function = nullptr;
    const std::size_t sign = line.find(" = ");
    const bool is_list = sign != std::string::npos && line[sign + 3] == '[';
    if (function == nullptr || sign == std::string::npos || is_list) continue;
    const std::size_t begin = line.find_first_not_of(' ');
    function->emplace_back(without_ends(line.substr(begin, sign - begin), "const double ", ""),
                           without_ends(line.substr(sign + 3), "", ";"));
  }
  if (torques_.empty()) throw FormulaError("the program has no statements");
}

void PrintedProgram::set(const std::string& name, double value) {
  values_[c_ ? "p->" + c_member(name) : "p[\"" + name + "\"]"] = value;
}

void PrintedProgram::run(const Statements& statements) {
  StatementMaker make{values_};
  for (const auto& [target, expression] : statements)
    values_[target] = ExpressionReader<double, StatementMaker>(expression, make).read();
}

void PrintedProgram::set_list(const char* list, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    values_[std::string(list) + "[" + std::to_string(i) + "]"] = values[i];
}

std::vector<double> PrintedProgram::torques(const std::vector<double>& q, const std::vector<double>& dq,
                                            const std::vector<double>& ddq) {
  set_list("q", q), set_list("dq", dq), set_list("ddq", ddq);
  run(torques_);
  std::vector<double> found;
  for (std::size_t i = 0; i < columns_; ++i) found.push_back(values_.at("tau[" + std::to_string(i) + "]"));
  return found;
}

}  // namespace balance::formulas
