#include "balance/formulas/text_value.hpp"

#include "balance/base/elementary.hpp"
#include "balance/formulas/expression.hpp"

#include <cmath>
#include <cstdlib>

namespace balance::formulas {

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
  ValueFactory make{values};
  return FormulaParser<double, ValueFactory>(text, make).read();
}

}  // namespace balance::formulas
