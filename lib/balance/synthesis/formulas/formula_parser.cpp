#include "balance/synthesis/formulas/formula_parser.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

namespace balance::formulas {

/// Makes instructions of an expression. A value is the register that it is in.
class ProgramInterpreter::Compiler {
 public:
  struct Value {
    Compiler* compiler;
    int index;

    Value operator+(const Value& b) const { return compiler->add(Operation::sum, *this, b); }
    Value operator-(const Value& b) const { return compiler->add(Operation::difference, *this, b); }
    Value operator*(const Value& b) const { return compiler->add(Operation::product, *this, b); }
    Value operator-() const { return compiler->add(Operation::negative, *this, *this); }
  };

  Compiler(ProgramInterpreter& program, std::vector<Instruction>& instructions)
      : program_(program), instructions_(instructions) {}

  void compile(const std::string& target, const std::string& expression) {
    const Value value = FormulaParser<Value, Compiler>(expression, *this).read();
    instructions_.push_back({Operation::copy, program_.register_of(target), value.index, value.index});
  }

  Value number(const std::string& text) { return {this, program_.add_register(std::strtod(text.c_str(), nullptr))}; }
  Value name(const std::string& name) { return {this, program_.register_of(name)}; }
  static bool is_function(const std::string& name) {
    return strip_math_prefix(name) == "sin" || strip_math_prefix(name) == "cos" || strip_math_prefix(name) == "sqrt";
  }
  Value call(const std::string& function, const Value& x) {
    const std::string name = strip_math_prefix(function);
    return add(name == "sin" ? Operation::sine : name == "cos" ? Operation::cosine : Operation::root, x, x);
  }
  static Value power(const Value&, int) { throw FormulaError("neither C nor Python writes powers so"); }
  Value quotient(const Value& a, const Value& b) { return add(Operation::quotient, a, b); }

 private:
  static std::string strip_math_prefix(const std::string& name) {
    return name.starts_with("math.") ? name.substr(5) : name;
  }
  Value add(Operation operation, const Value& a, const Value& b) {
    instructions_.push_back({operation, program_.add_register(0), a.index, b.index});
    return {this, instructions_.back().target};
  }

  ProgramInterpreter& program_;
  std::vector<Instruction>& instructions_;
};

namespace {

std::string strip_affixes(std::string text, const std::string& begin, const std::string& end) {
  if (text.starts_with(begin)) text.erase(0, begin.size());
  if (text.ends_with(end)) text.resize(text.size() - end.size());
  return text;
}

}  // namespace

ProgramInterpreter::ProgramInterpreter(const std::string& text, Language language, std::size_t columns)
    : is_c_(language == Language::c), columns_(columns) {
  std::vector<Instruction>* function = nullptr;
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
    Compiler(*this, *function)
        .compile(strip_affixes(line.substr(begin, equals_sign - begin), "const double ", ""),
                 strip_affixes(line.substr(equals_sign + 3), "", ";"));
  }
  if (functions_["torques"].empty() && functions_["tree_torques"].empty())
    throw FormulaError("the program has no statements");
}

int ProgramInterpreter::add_register(double value) {
  registers_.push_back(value);
  return static_cast<int>(registers_.size()) - 1;
}

int ProgramInterpreter::register_of(const std::string& name) {
  const auto [known, is_new] = names_.try_emplace(name, 0);
  if (is_new) known->second = add_register(std::numeric_limits<double>::quiet_NaN());
  return known->second;
}

void ProgramInterpreter::set_parameter(const std::string& name, double value) {
  const auto known = names_.find(is_c_ ? "p->" + c_member_name(name) : "p[\"" + name + "\"]");
  if (known != names_.end()) registers_[static_cast<std::size_t>(known->second)] = value;
}

void ProgramInterpreter::execute(const std::vector<Instruction>& instructions) {
  const auto at = [this](int index) -> double& { return registers_[static_cast<std::size_t>(index)]; };
  for (const auto& [operation, target, a, b] : instructions) {
    switch (operation) {
      case Operation::copy: at(target) = at(a); break;
      case Operation::sum: at(target) = at(a) + at(b); break;
      case Operation::difference: at(target) = at(a) - at(b); break;
      case Operation::product: at(target) = at(a) * at(b); break;
      case Operation::quotient: at(target) = at(a) / at(b); break;
      case Operation::negative: at(target) = -at(a); break;
      case Operation::cosine: at(target) = elementary::cos(at(a)); break;
      case Operation::sine: at(target) = elementary::sin(at(a)); break;
      case Operation::root: at(target) = std::sqrt(at(a)); break;
    }
  }
}

std::vector<std::vector<double>> ProgramInterpreter::call(
    const std::string& function, const std::map<std::string, std::vector<double>>& arguments,
    const std::vector<std::pair<std::string, std::size_t>>& results) {
  const auto element = [this](const std::string& list, std::size_t i) -> double& {
    const int index = register_of(list + "[" + std::to_string(i) + "]");
    return registers_[static_cast<std::size_t>(index)];
  };
  for (const auto& [list, values] : arguments)
    for (std::size_t i = 0; i < values.size(); ++i) element(list, i) = values[i];
  execute(functions_.at(function));
  std::vector<std::vector<double>> found;
  for (const auto& [list, size] : results) {
    found.emplace_back();
    for (std::size_t i = 0; i < size; ++i) found.back().push_back(element(list, i));
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
