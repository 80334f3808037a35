#include "balance/synthesis/conditions/condition_text.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::conditions;

namespace {

dynamics::Parameter parameter(const std::string& owner, const std::string& symbol) {
  dynamics::Parameter p;
  p.owner = owner;
  p.symbol = symbol;
  p.name = owner + "." + symbol;
  return p;
}

Conditions one_condition(std::vector<dynamics::Parameter> parameters, const std::vector<double>& coefficients) {
  Conditions c;
  c.parameters = std::move(parameters);
  c.matrix = Eigen::Map<const Eigen::RowVectorXd>(coefficients.data(), static_cast<Eigen::Index>(coefficients.size()));
  c.pivots = {0};
  return c;
}

/// How deep braces go where they must be zero in the end; −1 as soon as one closes that was not opened.
int open_braces(const std::string& latex) {
  int depth = 0;
  for (std::size_t i = 0; i < latex.size() && depth >= 0; ++i) {
    if (latex[i] == '\\')
      ++i;  // what follows a backslash is no brace
    else if (latex[i] == '{')
      ++depth;
    else if (latex[i] == '}')
      --depth;
  }
  return depth;
}

}  // namespace

TEST_CASE("parameters and symbols are letters with their owner below") {
  CHECK(parameter_latex(parameter("link2", "m")) == "m_{\\text{link2}}");
  CHECK(parameter_latex(parameter("link1", "mx")) == "(m x)_{\\text{link1}}");
  CHECK(parameter_latex(parameter("link1", "Ixy")) == "I_{xy,\\text{link1}}");
  CHECK(parameter_latex(parameter("s1", "k")) == "k_{\\text{s1}}");
  CHECK(parameter_latex(parameter("s1", "kaxby")) == "(k a_x b_y)_{\\text{s1}}");
  CHECK(symbol_latex("l1") == "l_{1}");
  CHECK(symbol_latex("l_max") == "l_{\\text{max}}");
  CHECK(symbol_latex("gamma3") == "\\gamma_{3}");
  CHECK(symbol_latex("base") == "\\mathit{base}");
  CHECK(symbol_latex("d5.ratio") == "\\mathit{ratio}_{\\text{d5}}");
  CHECK(symbol_latex("link1.B.x") == "x_{\\text{link1.B}}");
}

TEST_CASE("names of all kinds leave the braces balanced") {
  for (const char* name :
       {"a_b", "50%", "{", "}", "\\", "a\\}", "x^2~", "#1 & $2", "Träger", "_", "_1", "1", "a__b", "b_"}) {
    const Conditions c = one_condition({parameter(name, "m"), parameter(name, "Ixx")}, {1, -2.5e-7});
    CHECK_MESSAGE(open_braces(conditions_latex(c)) == 0, conditions_latex(c));
    CHECK_MESSAGE(open_braces(symbol_latex(name)) == 0, symbol_latex(name));
    CHECK(open_braces(symbol_latex(std::string(name) + "." + name)) == 0);
  }
  CHECK(parameter_latex(parameter("a_b", "m")) == "m_{\\text{a\\_b}}");
  CHECK(open_braces("{\\}") == 1);
}

TEST_CASE("a condition shows fractions, powers and signs") {
  const Conditions c = one_condition(
      {parameter("a", "mx"), parameter("b", "m"), parameter("c", "J"), parameter("d", "m")}, {1, 0.25, -3e-7, -1});
  CHECK(condition_latex(c, 0) ==
        "(m x)_{\\text{a}} + 0.25\\, m_{\\text{b}} - 3 \\cdot 10^{-7}\\, J_{\\text{c}} - m_{\\text{d}} = 0");
  ConditionNames names;
  names.symbols = {{"l1", "m", 0.5, {}}, {"l2", "m", 0.25, {}}};
  names.formulas = {{std::nullopt, CoefficientFormula{{1, 2, {{0, 2}, {1, -1}}}, {}},
                     CoefficientFormula{{1, 1, {{0, 1}}}, {{-1, 1, {{1, 1}}}, {-1, 1, {}}}}, std::nullopt}};
  CHECK(condition_latex(c, 0, names) ==
        "(m x)_{\\text{a}} + \\frac{l_{1}^{2}}{2\\, l_{2}}\\, m_{\\text{b}} "
        "- l_{1}\\, \\left(l_{2} + 1\\right)\\, J_{\\text{c}} - m_{\\text{d}} = 0");
  CHECK(formula_latex({{-1, 2, {}}, {}}, {}) == "-\\frac{1}{2}");
}

TEST_CASE("conditions stand one below the other, long ones on several lines") {
  std::vector<dynamics::Parameter> parameters(40, parameter("a", "m"));
  const std::string text = conditions_latex(one_condition(parameters, std::vector<double>(40, 1)));
  CHECK(text.starts_with("\\begin{align*}\n  & m_{\\text{a}} + m"));
  CHECK(text.ends_with("m_{\\text{a}} = 0\n\\end{align*}\n"));
  CHECK(text.find(" \\\\\n  & \\quad {}+ ") != std::string::npos);
}
