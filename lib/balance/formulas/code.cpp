#include "balance/formulas/code.hpp"

#include "balance/formulas/code_states.hpp"
#include "balance/formulas/dag_maker.hpp"
#include "balance/formulas/printed_program.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <set>

namespace balance::formulas {

namespace {

/// The shortest text that is this number.
std::string shortest_decimal(double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  std::string number(text, end);
  if (number.find_first_of(".en") == std::string::npos) number += ".0";
  return number;
}

}  // namespace

std::string c_member_name(const std::string& name) {
  static const std::set<std::string> words{
      "auto",     "break",  "case",     "char",   "const",  "continue", "default", "do",     "double",  "else",
      "enum",     "extern", "float",    "for",    "goto",   "if",       "inline",  "int",    "long",    "register",
      "restrict", "return", "short",    "signed", "sizeof", "static",   "struct",  "switch", "typedef", "union",
      "unsigned", "void",   "volatile", "while",  "and",    "as",       "assert",  "class",  "def",     "del",
      "elif",     "except", "from",     "global", "import", "in",       "is",      "lambda", "not",     "or",
      "pass",     "raise",  "try",      "with",   "yield"};
  return words.contains(name) ? name + "_" : name;
}

namespace {

/// Writes the nodes of a program in their order.
class CodeWriter {
 public:
  CodeWriter(const StraightLineProgram& arena, const std::vector<int>& outputs, Language language)
      : arena_(arena), c_(language == Language::c), names_(arena.size()), uses_(arena.size(), 0) {
    std::vector<int> waiting = outputs;
    std::vector<bool> seen(arena.size(), false);
    for (const int output : outputs) ++uses_[at(output)];
    while (!waiting.empty()) {
      const int node = waiting.back();
      waiting.pop_back();
      if (seen[at(node)]) continue;
      seen[at(node)] = true;
      used_.push_back(node);
      for (const int operand : operands(node)) ++uses_[at(operand)], waiting.push_back(operand);
    }
    std::sort(used_.begin(), used_.end());
    for (const int node : used_) keep_constants(node);
    for (const int output : outputs)
      if (!arena_[output].is_state_dependent) store_constant(output);
    for (const int node : used_) arena_[node].is_state_dependent ? write_moving(node) : write_constant(node);
  }

  std::string reference(int node) const {
    const ProgramNode& self = arena_[node];
    return self.operation == ProgramOperation::constant ? number(self.value) : names_[at(node)];
  }
  const std::string& prepare() const { return prepare_; }
  const std::string& body() const { return body_; }
  std::size_t constants() const { return kept_.size(); }
  CodeSize size() const { return size_; }
  std::string kept_reference(int node) const {
    const auto slot = kept_.find(node);
    return slot == kept_.end() ? reference(node) : "k[" + std::to_string(slot->second) + "]";
  }

 private:
  static std::size_t at(int node) { return static_cast<std::size_t>(node); }
  std::vector<int> operands(int node) const {
    const ProgramNode& self = arena_[node];
    if (self.operation == ProgramOperation::constant || self.operation == ProgramOperation::input) return {};
    if (is_unary(self.operation)) return {self.a};
    return {self.a, self.b};
  }
  static std::string number(double value) {
    return value < 0 ? "(" + shortest_decimal(value) + ")" : shortest_decimal(value);
  }

  void store_constant(int node) {
    if (arena_[node].operation != ProgramOperation::constant) kept_.try_emplace(node, static_cast<int>(kept_.size()));
  }
  /// What moving nodes need of those that do not.
  void keep_constants(int node) {
    if (!arena_[node].is_state_dependent) return;
    for (const int operand : operands(node))
      if (!arena_[operand].is_state_dependent) store_constant(operand);
  }

  std::string expression(int node, bool moving) const {
    const ProgramNode& self = arena_[node];
    const auto name = [&](int operand) { return moving ? kept_reference(operand) : reference(operand); };
    const std::string math = c_ ? "" : "math.";
    switch (self.operation) {
      case ProgramOperation::sum: return name(self.a) + " + " + name(self.b);
      case ProgramOperation::difference: return name(self.a) + " - " + name(self.b);
      case ProgramOperation::product: return name(self.a) + " * " + name(self.b);
      case ProgramOperation::negative: return "-" + name(self.a);
      case ProgramOperation::cosine: return math + "cos(" + name(self.a) + ")";
      case ProgramOperation::sine: return math + "sin(" + name(self.a) + ")";
      case ProgramOperation::root: return math + "sqrt(" + name(self.a) + ")";
      case ProgramOperation::inverse: return "1.0 / " + name(self.a);
      case ProgramOperation::input: return self.name;
      case ProgramOperation::constant: return number(self.value);
    }
    return "";
  }

  std::string line(const std::string& name, const std::string& value) const {
    return (c_ ? "  const double " : "    ") + name + " = " + value + (c_ ? ";\n" : "\n");
  }

  void write_constant(int node) {
    const ProgramNode& self = arena_[node];
    if (self.operation == ProgramOperation::constant) return;
    if (self.operation == ProgramOperation::input) {
      names_[at(node)] = c_ ? "p->" + c_member_name(self.name) : "p[\"" + self.name + "\"]";
    } else {
      names_[at(node)] = "n" + std::to_string(node);
      prepare_ += line(names_[at(node)], expression(node, false));
      ++size_.operations_once;
    }
    if (const auto slot = kept_.find(node); slot != kept_.end())
      prepare_ +=
          (c_ ? "  k[" : "    k[") + std::to_string(slot->second) + "] = " + names_[at(node)] + (c_ ? ";\n" : "\n");
  }

  void write_moving(int node) {
    const ProgramNode& self = arena_[node];
    if (self.operation == ProgramOperation::input) {
      names_[at(node)] = self.name;
      return;
    }
    const std::string text = expression(node, true);
    if (self.operation < ProgramOperation::cosine) ++size_.operations_per_state;
    if (uses_[at(node)] == 1 && text.size() < 60) {
      names_[at(node)] = "(" + text + ")";
      return;
    }
    names_[at(node)] = "t" + std::to_string(node);
    body_ += line(names_[at(node)], text);
  }

  const StraightLineProgram& arena_;
  bool c_;
  std::vector<std::string> names_;
  std::vector<int> uses_, used_;
  std::map<int, int> kept_;
  std::string prepare_, body_;
  CodeSize size_;
};

/// Names and values of a mechanism's numbers.
std::vector<std::pair<std::string, double>> parameters(const StraightLineProgram& arena, const Ring& ring) {
  std::set<std::string> used;
  for (std::size_t i = 0; i < arena.size(); ++i)
    if (const ProgramNode& node = arena[static_cast<int>(i)];
        node.operation == ProgramOperation::input && !node.is_state_dependent)
      used.insert(node.name);
  std::vector<std::pair<std::string, double>> list;
  for (const Symbol& symbol : ring.symbols())
    if (used.contains(symbol.name)) list.emplace_back(symbol.name, symbol.value);
  for (const Angle& angle : ring.angles())
    if (used.contains(angle.name)) list.emplace_back(angle.name, angle.value);
  if (list.empty()) list.emplace_back("none", 0.0);
  return list;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

struct ProgramParts {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::pair<std::string, double>> numbers;
  std::string prepare, body;  ///< torques included
  std::size_t constants = 0;
  SelfTestStates states;
};

std::string rows_text(const std::vector<std::vector<double>>& rows, const char* open, const char* close) {
  std::string text;
  for (const auto& row : rows) {
    std::vector<std::string> numbers;
    for (const double x : row) numbers.push_back(shortest_decimal(x));
    text += std::string("    ") + open + joined(numbers) + close + ",\n";
  }
  return text;
}

std::string c_program(const ProgramParts& p) {
  std::string members, values;
  for (const auto& [name, value] : p.numbers) {
    members += "  double " + c_member_name(name) + ";\n";
    values += "  ." + c_member_name(name) + " = " + shortest_decimal(value) + ",\n";
  }
  const std::string n = std::to_string(p.columns.size()), k = std::to_string(std::max<std::size_t>(p.constants, 1));
  std::string text =
      "/* Torques of " + p.title +
      ": M(q) ddq + velocity terms + weight and springs [N m or N].\n   Coordinates: " + joined(p.columns) +
      " [rad or m]. " + p.states.meaning + " */\n";
  text += "#include <math.h>\n#include <stdio.h>\n\nenum { coordinates = " + n + ", constants = " + k + " };\n\n";
  text += "/* The mechanism's numbers [SI]. */\ntypedef struct {\n" + members + "} Parameters;\n\n";
  text += "static const Parameters given = {\n" + values + "};\n\n";
  text +=
      "/* What depends on the mechanism alone: call it once. */\nstatic void prepare(const Parameters *p, double *k) "
      "{\n  (void)p;\n  (void)k;\n" +
      p.prepare + "}\n\n";
  text +=
      "static void torques(const double *k, const double *q, const double *dq, const double *ddq, double *tau) {\n  "
      "(void)k;\n  (void)q;\n  (void)dq;\n  (void)ddq;\n" +
      p.body + "}\n\n#ifndef WITHOUT_TEST\n";
  const auto table = [&](const char* name, const auto& rows) {
    return std::string("static const double ") + name + "[][coordinates] = {\n" + rows_text(rows, "{", "}") + "};\n";
  };
  text += table("test_q", p.states.q) + table("test_dq", p.states.dq) + table("test_ddq", p.states.ddq) +
          table("test_tau", p.states.torque);
  return text +
         "\nint main(void) {\n  double k[constants], tau[coordinates], worst = 0, scale = 0;\n  prepare(&given, k);\n"
         "  for (int s = 0; s < " +
         std::to_string(p.states.q.size()) +
         "; ++s) {\n"
         "    torques(k, test_q[s], test_dq[s], test_ddq[s], tau);\n    for (int i = 0; i < coordinates; ++i) {\n"
         "      worst = fmax(worst, fabs(tau[i] - test_tau[s][i]));\n      scale = fmax(scale, "
         "fabs(test_tau[s][i]));\n    }\n  }\n"
         "  printf(\"largest difference %.1e of %.6g\\n\", worst, scale);\n  return worst <= 1e-9 * scale ? 0 : "
         "1;\n}\n#endif\n";
}

std::string python_program(const ProgramParts& p) {
  std::string values;
  for (const auto& [name, value] : p.numbers) values += "    \"" + name + "\": " + shortest_decimal(value) + ",\n";
  std::string text =
      "\"\"\"Torques of " + p.title +
      ": M(q) ddq + velocity terms + weight and springs [N m or N].\n\nCoordinates: " + joined(p.columns) +
      " [rad or m]. " + p.states.meaning + "\"\"\"\n\nimport math\n\n";
  text += "# The mechanism's numbers [SI].\nGIVEN = {\n" + values + "}\n\n\n";
  text += "def prepare(p):\n    \"\"\"What depends on the mechanism alone: call it once.\"\"\"\n    k = [0.0] * " +
          std::to_string(p.constants) + "\n" + p.prepare + "    return k\n\n\n";
  text += "def torques(k, q, dq, ddq):\n    tau = [0.0] * " + std::to_string(p.columns.size()) + "\n" + p.body +
          "    return tau\n\n\n";
  const auto table = [&](const char* name, const auto& rows) {
    return std::string(name) + " = [\n" + rows_text(rows, "[", "]") + "]\n";
  };
  text += table("TEST_Q", p.states.q) + table("TEST_DQ", p.states.dq) + table("TEST_DDQ", p.states.ddq) +
          table("TEST_TAU", p.states.torque);
  return text +
         "\nif __name__ == \"__main__\":\n    k = prepare(GIVEN)\n    worst = scale = 0.0\n"
         "    for q, dq, ddq, expected in zip(TEST_Q, TEST_DQ, TEST_DDQ, TEST_TAU):\n"
         "        for found, right in zip(torques(k, q, dq, ddq), expected):\n"
         "            worst = max(worst, abs(found - right))\n            scale = max(scale, abs(right))\n"
         "    print(f\"largest difference {worst:.1e} of {scale:.6g}\")\n    raise SystemExit(0 if worst <= 1e-9 * "
         "scale else 1)\n";
}

}  // namespace

std::string generate_program(const Mechanism& mechanism, const SpecNumberTexts& texts, Language language,
                             CodeSize* size) {
  Ring ring;
  const SymbolicTree tree = build_symbolic_tree(ring, mechanism, texts);
  StraightLineProgram arena;
  std::vector<int> outputs;
  for (const ProgramValue& torque : build_torque_program(arena, ring, tree)) outputs.push_back(torque.node(arena));
  const CodeWriter writer(arena, outputs, language);
  const bool c = language == Language::c;
  ProgramParts program{comment_safe_title(mechanism.name),
                       tree.columns,
                       parameters(arena, ring),
                       writer.prepare(),
                       writer.body(),
                       writer.constants(),
                       make_self_test_states(mechanism, tree)};
  for (std::size_t i = 0; i < outputs.size(); ++i)
    program.body += (c ? "  tau[" : "    tau[") + std::to_string(i) + "] = " + writer.kept_reference(outputs[i]) +
                    (c ? ";\n" : "\n");
  if (size != nullptr) *size = writer.size();
  std::string text = c ? c_program(program) : python_program(program);
  check_program(ProgramInterpreter(text, language, outputs.size()), ring, tree, program.states);
  return text;
}

}  // namespace balance::formulas
