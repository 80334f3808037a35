#include "balance/synthesis/formulas/program_code.hpp"

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/model/topology.hpp"
#include "balance/mechanics/model/torque_distribution.hpp"
#include "balance/synthesis/formulas/closed_poses.hpp"
#include "balance/synthesis/formulas/closure_elimination.hpp"
#include "balance/synthesis/formulas/formula_parser.hpp"
#include "balance/synthesis/formulas/loop_program.hpp"
#include "balance/synthesis/formulas/parameter_sampler.hpp"
#include "balance/synthesis/formulas/straight_line_program.hpp"
#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace balance::formulas {

// States for a program's self-test, and for its check before it is printed.

/// Random states, one per row, and the torques there from another implementation.
struct SelfTestStates {
  std::vector<std::vector<double>> q, dq, ddq, torque;
  std::string meaning;  ///< a sentence about the coordinates and the source of the test's torques
};

/// Of a program without loops, or of the tree of one.
/// @param is_closed whether any loops are closed at all poses
/// @throws FormulaError
SelfTestStates make_self_test_states(const Mechanism& mechanism, const SymbolicTree& tree,
                                     const std::vector<int>& needed, bool is_closed);

/// Compares the program's torques of the tree with the engine at these states, and at single ones of them with other
/// parameters and free numbers.
/// @throws FormulaError if they differ
void check_program(ProgramInterpreter program, Ring& ring, const SymbolicTree& tree, const SelfTestStates& states,
                   const std::vector<int>& needed);

/// Chooses what the program of a mechanism with loops takes and gives.
/// @param straight_line the program's straight-line functions @param closures how many equations close the loops
/// @throws FormulaError if its loops do not close
LoopProgram make_loop_program(const Mechanism& mechanism, const Ring& ring, const SymbolicTree& tree,
                              std::size_t closures, ProgramInterpreter& straight_line, const ProgramOptions& options);
/// States of the program's arguments, and the engine's efforts.
SelfTestStates make_loop_states(const Mechanism& mechanism, const SymbolicTree& tree, ProgramInterpreter& straight_line,
                                const LoopProgram& program);
/// Compares the independent coordinates' torques at other parameters and free numbers.
/// @throws FormulaError if they differ
void check_loop_program(ProgramInterpreter& straight_line, Ring& ring, const SymbolicTree& tree,
                        const LoopProgram& program);

/// A name that cannot end a comment.
std::string comment_safe_title(const std::string& name);

std::string shortest_decimal(double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  std::string number(text, end);
  if (number.find_first_of(".en") == std::string::npos) number += ".0";
  return number;
}

std::string c_member_name(const std::string& name) {
  static const std::set<std::string> keywords{
      "auto",     "break",  "case",     "char",   "const",  "continue", "default", "do",     "double",  "else",
      "enum",     "extern", "float",    "for",    "goto",   "if",       "inline",  "int",    "long",    "register",
      "restrict", "return", "short",    "signed", "sizeof", "static",   "struct",  "switch", "typedef", "union",
      "unsigned", "void",   "volatile", "while",  "and",    "as",       "assert",  "class",  "def",     "del",
      "elif",     "except", "from",     "global", "import", "in",       "is",      "lambda", "not",     "or",
      "pass",     "raise",  "try",      "with",   "yield"};
  return keywords.contains(name) ? name + "_" : name;
}

namespace {

/// A function without branches: what it assigns, and the statements.
struct CodeFunction {
  std::string name;
  std::vector<std::string> arguments;                        ///< arrays
  std::vector<std::pair<std::string, std::size_t>> results;  ///< arrays and their sizes
  std::vector<ProgramValue> outputs;                         ///< all entries of all results
  std::string body = {};
};

/// Writes the nodes of functions in order. What does not depend on the state is computed once, in `prepare`.
class CodeWriter {
 public:
  CodeWriter(StraightLineProgram& arena, std::vector<CodeFunction>& functions, Language language)
      : arena_(arena), is_c_(language == Language::c) {
    std::vector<std::vector<int>> outputs;
    for (const CodeFunction& function : functions) {
      outputs.emplace_back();
      for (const ProgramValue& output : function.outputs) outputs.back().push_back(output.node(arena));
    }
    names_.resize(arena.size());
    std::set<int> constants;
    for (const std::vector<int>& nodes : outputs) {
      visit(nodes);
      for (const int node : reachable_) {
        store_constant_operands(node);
        if (!arena_[node].is_state_dependent) constants.insert(node);
      }
      for (const int output : nodes)
        if (!arena_[output].is_state_dependent) store_constant(output);
    }
    for (const int node : constants) write_constant(node);
    for (std::size_t f = 0; f < functions.size(); ++f) {
      visit(outputs[f]);
      body_.clear();
      for (const int node : reachable_)
        if (arena_[node].is_state_dependent) write_state_dependent(node);
      std::size_t next = 0;
      for (const auto& [list, size] : functions[f].results)
        for (std::size_t i = 0; i < size; ++i)
          body_ += (is_c_ ? "  " : "    ") + list + "[" + std::to_string(i) +
                   "] = " + stored_reference(outputs[f][next++]) + (is_c_ ? ";\n" : "\n");
      functions[f].body = body_;
    }
  }

  const std::string& prepare() const { return prepare_; }
  std::size_t constants() const { return constant_slots_.size(); }
  CodeSize size() const { return size_; }

 private:
  /// Lists what a function's outputs depend on, and counts the uses.
  void visit(const std::vector<int>& outputs) {
    uses_.assign(arena_.size(), 0);
    reachable_.clear();
    std::vector<int> stack = outputs;
    std::vector<bool> is_visited(arena_.size(), false);
    for (const int output : outputs) ++uses_[as_index(output)];
    while (!stack.empty()) {
      const int node = stack.back();
      stack.pop_back();
      if (is_visited[as_index(node)]) continue;
      is_visited[as_index(node)] = true;
      reachable_.push_back(node);
      for (const int operand : operands(node)) ++uses_[as_index(operand)], stack.push_back(operand);
    }
    std::sort(reachable_.begin(), reachable_.end());
  }
  std::string reference(int node) const {
    const ProgramNode& self = arena_[node];
    return self.operation == ProgramOperation::constant ? number(self.value) : names_[as_index(node)];
  }
  std::string stored_reference(int node) const {
    const auto slot = constant_slots_.find(node);
    return slot == constant_slots_.end() ? reference(node) : "k[" + std::to_string(slot->second) + "]";
  }
  static std::size_t as_index(int node) { return static_cast<std::size_t>(node); }
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
    if (arena_[node].operation != ProgramOperation::constant)
      constant_slots_.try_emplace(node, static_cast<int>(constant_slots_.size()));
  }
  /// Stores the constant operands of a state-dependent node.
  void store_constant_operands(int node) {
    if (!arena_[node].is_state_dependent) return;
    for (const int operand : operands(node))
      if (!arena_[operand].is_state_dependent) store_constant(operand);
  }

  std::string expression(int node, bool is_state_dependent) const {
    const ProgramNode& self = arena_[node];
    const auto name = [&](int operand) { return is_state_dependent ? stored_reference(operand) : reference(operand); };
    const std::string math = is_c_ ? "" : "math.";
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
    return (is_c_ ? "  const double " : "    ") + name + " = " + value + (is_c_ ? ";\n" : "\n");
  }

  void write_constant(int node) {
    const ProgramNode& self = arena_[node];
    if (self.operation == ProgramOperation::constant) return;
    if (self.operation == ProgramOperation::input) {
      names_[as_index(node)] = is_c_ ? "p->" + c_member_name(self.name) : "p[\"" + self.name + "\"]";
    } else {
      names_[as_index(node)] = "n" + std::to_string(node);
      prepare_ += line(names_[as_index(node)], expression(node, false));
      ++size_.operations_once;
    }
    if (const auto slot = constant_slots_.find(node); slot != constant_slots_.end())
      prepare_ += (is_c_ ? "  k[" : "    k[") + std::to_string(slot->second) + "] = " + names_[as_index(node)] +
                  (is_c_ ? ";\n" : "\n");
  }

  void write_state_dependent(int node) {
    const ProgramNode& self = arena_[node];
    if (self.operation == ProgramOperation::input) {
      names_[as_index(node)] = self.name;
      return;
    }
    const std::string text = expression(node, true);
    if (self.operation < ProgramOperation::cosine) ++size_.operations_per_state;
    if (uses_[as_index(node)] == 1 && text.size() < 60) {
      names_[as_index(node)] = "(" + text + ")";
      return;
    }
    names_[as_index(node)] = "t" + std::to_string(node);
    body_ += line(names_[as_index(node)], text);
  }

  const StraightLineProgram& arena_;
  bool is_c_;
  std::vector<std::string> names_;
  std::vector<int> uses_, reachable_;
  std::map<int, int> constant_slots_;
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

std::string join_text(const std::vector<std::string>& parts) { return fmt::format("{}", fmt::join(parts, ", ")); }

struct ProgramParts {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::pair<std::string, double>> numbers;
  std::string prepare;
  std::size_t constants = 0, closures = 0;
  std::vector<CodeFunction> functions;
  std::optional<LoopProgram> loops;
  SelfTestStates states;
};

std::string rows_text(const std::vector<std::vector<double>>& rows, const char* open, const char* close) {
  std::string text;
  for (const auto& row : rows) {
    std::vector<std::string> numbers;
    for (const double x : row) numbers.push_back(shortest_decimal(x));
    text += std::string("    ") + open + join_text(numbers) + close + ",\n";
  }
  return text;
}

/// What the program computes, and of what.
std::string describe_program(const ProgramParts& p) {
  std::string text = "Torques of " + p.title;
  if (p.loops) {
    text += ", of " + join_text(p.loops->motors) + ": C^T (M ddq + velocity terms + weight and springs) [N m or N].";
  } else {
    text += ": M(q) ddq + velocity terms + weight and springs [N m or N].";
  }
  std::vector<std::string> names = p.columns;
  if (p.loops) {
    names.clear();
    for (const std::size_t column : p.loops->independent) names.push_back(p.columns[column]);
  }
  const bool has_two_lists = p.loops && p.loops->has_all_coordinates;
  return text + "\nCoordinates: " + join_text(has_two_lists ? p.columns : names) + " [rad or m]. " +
         (p.loops && !has_two_lists ? "All coordinates: " + join_text(p.columns) + ". " : "") + p.states.meaning;
}

/// `"enum { coordinates = 4, … }"`.
std::string c_sizes(const ProgramParts& p) {
  std::string text = "enum { coordinates = " + std::to_string(p.columns.size());
  if (p.loops)
    text += ", closure_rows = " + std::to_string(p.loops->closures) +
            ", freedoms = " + std::to_string(p.loops->independent.size()) +
            ", dependents = " + std::to_string(p.loops->dependent.size()) +
            ", motors = " + std::to_string(p.loops->motors.size());
  return text + ", constants = " + std::to_string(std::max<std::size_t>(p.constants, 1)) + " };\n\n";
}

std::string c_function(const CodeFunction& function) {
  std::string parameters = "const double *k", unused = "  (void)k;\n";
  for (const std::string& argument : function.arguments)
    parameters += ", const double *" + argument, unused += "  (void)" + argument + ";\n";
  for (const auto& [list, size] : function.results) parameters += ", double *" + list;
  return "static void " + function.name + "(" + parameters + ") {\n" + unused + function.body + "}\n\n";
}

/// The test, with the names of its tables, of the arrays' sizes and of the call.
std::string c_test(const ProgramParts& p) {
  const bool has_loops = p.loops.has_value(), closes = has_loops && !p.loops->has_all_coordinates;
  const std::string size = closes ? "freedoms" : "coordinates", outputs = has_loops ? "motors" : "coordinates";
  const auto table = [&](const char* name, const std::string& columns, const auto& rows) {
    return std::string("static const double ") + name + "[][" + columns + "] = {\n" + rows_text(rows, "{", "}") +
           "};\n";
  };
  const std::string arguments = "k, test_q[s], test_dq[s], test_ddq[s], " + std::string(closes ? "q, tau" : "tau");
  return "#ifndef WITHOUT_TEST\n" + table("test_q", size, p.states.q) + table("test_dq", size, p.states.dq) +
         table("test_ddq", size, p.states.ddq) + table("test_tau", outputs, p.states.torque) +
         "\nint main(void) {\n  double k[constants], tau[" + outputs +
         "], worst = 0, scale = 0;\n  prepare(&given, k);\n"
         "  for (int s = 0; s < " +
         std::to_string(p.states.q.size()) + "; ++s) {\n" +
         (closes ? "    double q[coordinates];\n    for (int i = 0; i < coordinates; ++i) q[i] = start[i];\n" : "") +
         (has_loops ? "    if (torques(" + arguments +
                          ")) {\n      printf(\"the loops do not close\\n\");\n      return 1;\n    }\n"
                    : "    torques(" + arguments + ");\n") +
         "    for (int i = 0; i < " + outputs +
         "; ++i) {\n"
         "      worst = fmax(worst, fabs(tau[i] - test_tau[s][i]));\n      scale = fmax(scale, "
         "fabs(test_tau[s][i]));\n    }\n  }\n"
         "  printf(\"largest difference %.1e of %.6g\\n\", worst, scale);\n  return worst <= 1e-9 * scale ? 0 : "
         "1;\n}\n#endif\n";
}

std::string c_program(const ProgramParts& p) {
  std::string members, values;
  for (const auto& [name, value] : p.numbers) {
    members += "  double " + c_member_name(name) + ";\n";
    values += "  ." + c_member_name(name) + " = " + shortest_decimal(value) + ",\n";
  }
  std::string text = "/* " + describe_program(p) + " */\n";
  text += "#include <math.h>\n#include <stdio.h>\n\n" + c_sizes(p);
  text += "/* The mechanism's numbers [SI]. */\ntypedef struct {\n" + members + "} Parameters;\n\n";
  text += "static const Parameters given = {\n" + values + "};\n\n";
  text +=
      "/* What depends on the mechanism alone: call it once. */\nstatic void prepare(const Parameters *p, double *k) "
      "{\n  (void)p;\n  (void)k;\n" +
      p.prepare + "}\n\n";
  for (const CodeFunction& function : p.functions) text += c_function(function);
  if (p.loops) text += format_loop_functions(*p.loops, Language::c) + "\n";
  return text + c_test(p);
}

std::string python_function(const CodeFunction& function) {
  std::string parameters = "k", lists, returned;
  for (const std::string& argument : function.arguments) parameters += ", " + argument;
  for (const auto& [list, size] : function.results) {
    lists += "    " + list + " = [0.0] * " + std::to_string(size) + "\n";
    returned += (returned.empty() ? "" : ", ") + list;
  }
  return "def " + function.name + "(" + parameters + "):\n" + lists + function.body + "    return " + returned +
         "\n\n\n";
}

std::string python_program(const ProgramParts& p) {
  const bool closes = p.loops && !p.loops->has_all_coordinates;
  std::string values;
  for (const auto& [name, value] : p.numbers) values += "    \"" + name + "\": " + shortest_decimal(value) + ",\n";
  std::string text = "\"\"\"" + describe_program(p) + "\"\"\"\n\nimport math\n\n";
  text += "# The mechanism's numbers [SI].\nGIVEN = {\n" + values + "}\n\n\n";
  text += "def prepare(p):\n    \"\"\"What depends on the mechanism alone: call it once.\"\"\"\n    k = [0.0] * " +
          std::to_string(p.constants) + "\n" + p.prepare + "    return k\n\n\n";
  for (const CodeFunction& function : p.functions) text += python_function(function);
  if (p.loops) text += format_loop_functions(*p.loops, Language::python);
  const auto table = [&](const char* name, const auto& rows) {
    return std::string(name) + " = [\n" + rows_text(rows, "[", "]") + "]\n";
  };
  text += table("TEST_Q", p.states.q) + table("TEST_DQ", p.states.dq) + table("TEST_DDQ", p.states.ddq) +
          table("TEST_TAU", p.states.torque);
  return text +
         "\nif __name__ == \"__main__\":\n    k = prepare(GIVEN)\n    worst = scale = 0.0\n"
         "    for q, dq, ddq, expected in zip(TEST_Q, TEST_DQ, TEST_DDQ, TEST_TAU):\n"
         "        for found, right in zip(torques(k, q, dq, ddq)" +
         (closes ? "[0]" : "") +
         ", expected):\n"
         "            worst = max(worst, abs(found - right))\n            scale = max(scale, abs(right))\n"
         "    print(f\"largest difference {worst:.1e} of {scale:.6g}\")\n    raise SystemExit(0 if worst <= 1e-9 * "
         "scale else 1)\n";
}

/// The functions without branches; with loops, the torques of the motors are computed from these.
std::vector<CodeFunction> list_functions(TreeProgram program, std::size_t columns, bool has_loops) {
  const std::size_t rows = program.closures.size();
  std::vector<CodeFunction> functions{
      {has_loops ? "tree_torques" : "torques", {"q", "dq", "ddq"}, {{"tau", columns}}, std::move(program.torques)}};
  if (!has_loops) return functions;
  std::vector<ProgramValue> closures = std::move(program.closures);
  closures.insert(closures.end(), program.jacobian.begin(), program.jacobian.end());
  functions.push_back({"closures", {"q"}, {{"h", rows}, {"A", rows * columns}}, std::move(closures)});
  functions.push_back({"closure_bias", {"q", "dq"}, {{"b", rows}}, std::move(program.bias)});
  const std::size_t inputs = program.inputs.size();
  functions.push_back({"inputs", {}, {{"S", inputs}}, std::move(program.inputs)});
  return functions;
}

std::string program_text(const ProgramParts& parts, Language language) {
  return language == Language::c ? c_program(parts) : python_program(parts);
}

/// @param numbers the ring with its current values
void assign_values(ProgramInterpreter& program, const Ring& numbers) {
  for (const Symbol& symbol : numbers.symbols()) program.set_parameter(symbol.name, symbol.value);
  for (const Angle& angle : numbers.angles()) program.set_parameter(angle.name, angle.value);
  program.prepare();
}

}  // namespace

std::string generate_program(const Mechanism& spec_mechanism, const study::SpecNumberTexts& texts, Language language,
                             CodeSize* size, const ProgramOptions& options) {
  const Mechanism mechanism = attach_payloads(spec_mechanism);
  Ring ring;
  std::vector<int> needed;
  for (const CoordinateId c : find_coordinates(mechanism, options.independent)) needed.push_back(c);
  TreeOptions tree_options;
  tree_options.needed = find_coordinates(mechanism, options.independent);
  const SymbolicTree tree = build_symbolic_tree(ring, mechanism, texts, tree_options);
  const auto make_parts = [&](bool has_loops, bool is_closed) {
    StraightLineProgram arena;
    TreeProgram tree_program = build_tree_program(arena, ring, tree, mechanism.actuators);
    ProgramParts parts{comment_safe_title(mechanism.name), tree.columns, {}, "", 0,
                       tree_program.closures.size(),       {},           {}, {}};
    parts.functions = list_functions(std::move(tree_program), tree.columns.size(), has_loops);
    const CodeWriter writer(arena, parts.functions, language);
    for (CodeFunction& function : parts.functions) function.outputs.clear();  // they refer to the arena
    parts.numbers = parameters(arena, ring);
    parts.prepare = writer.prepare();
    parts.constants = writer.constants();
    if (size != nullptr) *size = writer.size();
    parts.states = make_self_test_states(mechanism, tree, needed, is_closed);
    ProgramInterpreter straight_line(program_text(parts, language), language, tree.columns.size());
    check_program(straight_line, ring, tree, parts.states, needed);
    return std::pair(std::move(parts), std::move(straight_line));
  };
  if (tree.closures.empty()) {
    check_independent_without_loops(mechanism, tree, options.independent);
    return program_text(make_parts(false, true).first, language);
  }
  if (has_velocity_constraints(mechanism)) return program_text(make_parts(false, false).first, language);
  auto checked = make_parts(true, false);
  ProgramParts& parts = checked.first;
  ProgramInterpreter& straight_line = checked.second;
  parts.loops = make_loop_program(mechanism, ring, tree, parts.closures, straight_line, options);
  const bool is_always_closed = parts.loops->dependent.empty();
  if (is_always_closed) return program_text(make_parts(false, true).first, language);
  std::erase_if(parts.functions, [&](const CodeFunction& function) {
    return (function.name == "inputs" && !parts.loops->direct.empty()) ||
           (function.name == "closure_bias" && parts.loops->has_all_coordinates);
  });
  parts.states = make_loop_states(mechanism, tree, straight_line, *parts.loops);
  check_loop_program(straight_line, ring, tree, *parts.loops);
  return program_text(parts, language);
}

namespace {

constexpr int self_test_state_count = 5;
constexpr int perturbed_self_test_count = 2;

/// Round-off of a program is far below this, a wrong term far above.
constexpr double program_tolerance = 1e-9;

/// Opens a loop at a joint of the tree: the joint then carries a massless copy of its body.
void split_body(Mechanism& mechanism, const model::TreeEdge& edge) {
  Joint& joint = mechanism.joints[static_cast<std::size_t>(edge.joint)];
  BodyId& end = edge.forward ? joint.second : joint.first;
  Body copy{.name = "copy " + std::to_string(mechanism.bodies.size())};
  end = static_cast<int>(mechanism.bodies.size());
  mechanism.bodies.push_back(std::move(copy));
}

/// The mechanism without loops, friction and loads, as the program models it, with an actuator at every column.
Mechanism remove_loops(Mechanism mechanism, const SymbolicTree& tree, const std::vector<int>& needed) {
  const model::SpanningTree edges =
      model::build_spanning_tree(mechanism, std::vector<CoordinateId>(needed.begin(), needed.end()));
  for (const model::TreeEdge& edge : edges.edges)
    if (edge.split) split_body(mechanism, edge);
  mechanism.friction.clear();
  mechanism.loads.clear();
  mechanism.force_elements.clear();
  mechanism.constraints.clear();
  for (Joint& joint : mechanism.joints) joint.slips = true;
  mechanism.assembly.clear();
  const std::vector<Joint> joints = std::move(mechanism.joints);
  const std::vector<Coordinate> coordinates = std::move(mechanism.coordinates);
  mechanism.joints.clear();
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (!std::binary_search(edges.cut.begin(), edges.cut.end(), static_cast<int>(j)))
      mechanism.joints.push_back(joints[j]);
  mechanism.coordinates = list_coordinates(mechanism.space, mechanism.joints);
  std::map<std::string, int> coordinate_ids;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    coordinate_ids.emplace(mechanism.coordinates[c].name, static_cast<int>(c));
  const auto coordinate_id = [&](int c) { return coordinate_ids.at(coordinates[static_cast<std::size_t>(c)].name); };
  const auto renumber = [&](model::CoordinateCombination& followed) {
    for (model::CoordinateTerm& term : followed.terms) term.coordinate = coordinate_id(term.coordinate);
  };
  for (Coupling& coupling : mechanism.couplings)
    coupling.follower = coordinate_id(coupling.follower), renumber(coupling.leader);
  for (Disc& disc : mechanism.discs) renumber(disc.follows);
  for (Spring& spring : mechanism.springs)
    if (spring.is_joint_spring()) spring.coordinate = coordinate_id(spring.coordinate);
  mechanism.actuators.clear();
  mechanism.torque_distribution.reset();
  for (const int c : tree.coordinates) mechanism.actuators.push_back(coordinate_id(c));
  return mechanism;
}

/// The engine's torques for a mechanism's spanning tree.
class TreeInverseDynamics {
 public:
  TreeInverseDynamics(const Mechanism& mechanism, const SymbolicTree& tree, const std::vector<int>& needed)
      : engine_(remove_loops(mechanism, tree, needed), make_options(mechanism, tree)) {}

  std::vector<double> compute_torques(const std::vector<double>& q, const std::vector<double>& dq,
                                      const std::vector<double>& ddq) {
    const auto vector = [](const std::vector<double>& v) {
      return VectorX(Eigen::Map<const VectorX>(v.data(), static_cast<Eigen::Index>(v.size())));
    };
    VectorX effort;
    const MotionOutcome outcome = engine_.efforts(vector(q), vector(dq), vector(ddq), effort);
    if (outcome.status != MotionStatus::done) throw FormulaError("the engine has no torques to test the program with");
    return to_list(effort);
  }

 private:
  static InverseOptions make_options(const Mechanism& mechanism, const SymbolicTree& tree) {
    InverseOptions options;
    options.independent = coordinate_names(mechanism, tree);
    return options;
  }
  InverseDynamics engine_;
};

/// Maximum difference between torques, and maximum torque.
struct TorqueDifference {
  double max_error = 0, max_torque = 0;

  void add(const std::vector<double>& computed, const std::vector<double>& expected) {
    for (std::size_t i = 0; i < computed.size(); ++i) {
      const double d = std::abs(computed[i] - expected[i]);
      max_error = std::isfinite(d) ? std::max(max_error, d) : std::numeric_limits<double>::infinity();
      max_torque = std::max(max_torque, std::abs(expected[i]));
    }
  }
  bool is_within_tolerance() const { return max_error <= program_tolerance * max_torque; }
};

}  // namespace

SelfTestStates make_self_test_states(const Mechanism& mechanism, const SymbolicTree& tree,
                                     const std::vector<int>& needed, bool is_closed) {
  SelfTestStates states;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  if (!is_closed) states.meaning = "Loops are not closed: these are the torques of the spanning tree. ";
  states.meaning += "The test's torques are those of the program balance.";
  TreeInverseDynamics engine(mechanism, tree, needed);
  for (int s = 0; s < self_test_state_count; ++s) {
    const auto random_row = [&] {
      std::vector<double> values;
      for (std::size_t i = 0; i < tree.columns.size(); ++i) values.push_back(uniform(random));
      return values;
    };
    const std::vector<double> q = random_row(), dq = random_row(), ddq = random_row();
    states.q.push_back(q), states.dq.push_back(dq), states.ddq.push_back(ddq);
    states.torque.push_back(engine.compute_torques(q, dq, ddq));
  }
  return states;
}

void check_program(ProgramInterpreter program, Ring& ring, const SymbolicTree& tree, const SelfTestStates& states,
                   const std::vector<int>& needed) {
  assign_values(program, ring);
  TorqueDifference nominal_difference;
  for (std::size_t s = 0; s < states.q.size(); ++s)
    nominal_difference.add(program.compute_torques(states.q[s], states.dq[s], states.ddq[s]), states.torque[s]);
  if (!nominal_difference.is_within_tolerance()) throw FormulaError("the program differs from the engine");
  std::mt19937_64 random(1);
  std::size_t s = 0;
  const auto compare = [&](const Mechanism& mechanism) {
    assign_values(program, ring);
    TreeInverseDynamics engine(mechanism, tree, needed);
    TorqueDifference perturbed_difference;
    perturbed_difference.add(program.compute_torques(states.q[s], states.dq[s], states.ddq[s]),
                             engine.compute_torques(states.q[s], states.dq[s], states.ddq[s]));
    ++s;
    if (!perturbed_difference.is_within_tolerance())
      throw FormulaError("the program differs from the engine at other numbers");
    return true;
  };
  ParameterSampler(ring, *tree.model).compare_perturbed(perturbed_self_test_count, random, compare);
}

namespace {

/// Steps along the independent coordinates: a tenth of a radian, or of the mechanism's length.
constexpr double max_step_fraction = 0.1;
/// Test states differ from the start by up to this, in radians or lengths, and by less at later attempts.
constexpr double max_state_offset = 0.3;
constexpr int max_state_attempts = 60;
constexpr std::size_t start_pose_count = 3;
/// Smallest singular value of the dependent coordinates' Jacobian at the start, relative to the largest.
constexpr double min_start_regularity = 2e-3;

/// The mechanism as the program models it.
Mechanism remove_unmodelled_forces(Mechanism mechanism) {
  mechanism.friction.clear();
  mechanism.loads.clear();
  mechanism.force_elements.clear();
  return mechanism;
}

/// The same with an actuator at each independent coordinate.
Mechanism drive_independent(Mechanism mechanism, const SymbolicTree& tree, const LoopProgram& program) {
  mechanism.actuators.clear();
  mechanism.torque_distribution.reset();
  for (const std::size_t column : program.independent) mechanism.actuators.emplace_back(tree.coordinates[column]);
  return mechanism;
}

/// The engine at poses of the program.
class LoopInverseDynamics {
 public:
  LoopInverseDynamics(const Mechanism& mechanism, const SymbolicTree& tree, const LoopProgram& program)
      : mechanism_(mechanism), tree_(tree), program_(program), engine_(mechanism, make_options()) {}

  /// @return whether the engine's pose at these independent coordinates is this one
  bool assemble(const VectorX& pose) {
    return assemble_engine(engine_, mechanism_, tree_, independent_of(pose), pose).has_value();
  }
  bool compute(const VectorX& pose, const VectorX& dx, const VectorX& ddx, VectorX& effort) {
    return engine_.efforts(independent_of(pose), dx, ddx, effort).status == MotionStatus::done && effort.allFinite();
  }

 private:
  InverseOptions make_options() const {
    InverseOptions options;
    options.independent = coordinate_names(mechanism_, tree_, program_.independent);
    return options;
  }
  VectorX independent_of(const VectorX& pose) const {
    VectorX x(static_cast<Eigen::Index>(program_.independent.size()));
    for (Eigen::Index u = 0; u < x.size(); ++u)
      x[u] = pose[static_cast<Eigen::Index>(program_.independent[static_cast<std::size_t>(u)])];
    return x;
  }

  Mechanism mechanism_;
  const SymbolicTree& tree_;
  const LoopProgram& program_;
  InverseDynamics engine_;
};

VectorX random_row(std::mt19937_64& random, Eigen::Index size) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  VectorX x(size);
  for (double& entry : x) entry = uniform(random);
  return x;
}

/// The first pose that is not nearly singular, where it is uncertain to which side the loops go on; else the most regular
/// one.
VectorX choose_start(const std::vector<VectorX>& poses, LoopProgramRunner& runner) {
  std::size_t best = 0;
  double best_regularity = 0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const double regularity = runner.regularity(poses[k]);
    if (regularity > min_start_regularity) return poses[k];
    if (regularity > best_regularity) best = k, best_regularity = regularity;
  }
  return poses[best];
}

/// Whether the program gives the torques of motors at the independent coordinates: the mechanism's own are too few, or
/// their torques are no linear function of these.
bool drives_independent_coordinates(const Mechanism& mechanism, const LoopProgram& program) {
  const std::size_t freedoms = program.independent.size();
  return mechanism.actuators.size() < freedoms ||
         (mechanism.actuators.size() > freedoms && !model::has_linear_efforts(mechanism));
}

/// What drives the mechanism: motors at the independent coordinates, motors whose torques are solved for, or, if these
/// are too few, the independent coordinates themselves.
void add_motors(const Mechanism& mechanism, const SymbolicTree& tree, LoopProgram& program) {
  std::vector<std::size_t> direct;
  for (const int actuator : mechanism.actuators) {
    program.motors.push_back(mechanism.coordinates[static_cast<std::size_t>(actuator)].name);
    program.force_units.push_back(is_length_coordinate(mechanism, actuator) ? program.length : 1);
    for (std::size_t u = 0; u < program.independent.size(); ++u)
      if (tree.coordinates[program.independent[u]] == actuator) direct.push_back(u);
  }
  const std::size_t freedoms = program.independent.size();
  if (mechanism.torque_distribution && model::has_linear_efforts(mechanism))
    program.force_units = model::scale_distribution(mechanism, program.length).unit;
  if (drives_independent_coordinates(mechanism, program)) {
    program.motors.clear(), direct.clear();
    for (std::size_t u = 0; u < freedoms; ++u) {
      direct.push_back(u);
      program.motors.push_back(tree.columns[program.independent[u]]);
    }
  }
  if (direct.size() == freedoms && program.motors.size() == freedoms) program.direct = std::move(direct);
}

}  // namespace

LoopProgram make_loop_program(const Mechanism& mechanism, const Ring& ring, const SymbolicTree& tree,
                              std::size_t closures, ProgramInterpreter& straight_line, const ProgramOptions& options) {
  assign_values(straight_line, ring);
  LoopProgram program;
  program.columns = tree.columns.size();
  program.has_all_coordinates = options.coordinates == ProgramCoordinates::all;
  program.length = characteristic_length(mechanism);
  program.closures = closures;
  LoopProgram movable = program;
  for (std::size_t c = 0; c < program.columns; ++c) movable.dependent.push_back(c);
  LoopProgramRunner assembler(straight_line, movable), runner(straight_line, program);
  std::vector<VectorX> poses =
      find_closed_poses(rough_pose(tree, options.start.empty() ? mechanism.assembly : options.start), start_pose_count,
                        1, [&](VectorX& q) { return assembler.close_loops(q); });
  std::vector<MatrixX> jacobians;
  for (const VectorX& q : poses) jacobians.push_back(runner.closures(q).A);
  const ClosureChoice choice =
      choose_independent_columns(mechanism, tree, options.independent, std::move(poses), std::move(jacobians));
  if (choice.independent.empty()) throw FormulaError("the mechanism has no degrees of freedom");
  program.dependent = choice.dependent;
  program.start = to_list(choose_start(choice.poses, runner));
  for (const int column : choice.independent) {
    const auto c = static_cast<std::size_t>(column);
    program.independent.push_back(c);
    program.max_steps.push_back(max_step_fraction *
                                (is_length_coordinate(mechanism, tree.coordinates[c]) ? program.length : 1));
  }
  add_motors(mechanism, tree, program);
  return program;
}

SelfTestStates make_loop_states(const Mechanism& mechanism, const SymbolicTree& tree, ProgramInterpreter& straight_line,
                                const LoopProgram& program) {
  SelfTestStates states;
  if (program.has_all_coordinates) states.meaning = "The coordinates must close the loops. ";
  const bool has_own_motors = drives_independent_coordinates(mechanism, program);
  if (has_own_motors)
    states.meaning +=
        mechanism.actuators.size() < program.independent.size()
            ? "The actuators are too few: these are the torques of motors at the independent coordinates. "
            : "The spec distributes efforts within bounds or by their peak: these are the torques of "
              "motors at the independent coordinates. ";
  states.meaning += "The test's torques are those of the program balance.";
  Mechanism modelled = remove_unmodelled_forces(mechanism);
  if (has_own_motors) modelled = drive_independent(std::move(modelled), tree, program);
  LoopInverseDynamics engine(modelled, tree, program);
  LoopProgramRunner runner(straight_line, program);
  std::mt19937_64 random(1);
  const auto freedoms = static_cast<Eigen::Index>(program.independent.size());
  const VectorX start = Eigen::Map<const VectorX>(program.start.data(), static_cast<Eigen::Index>(program.columns));
  for (int attempt = 0; attempt < max_state_attempts && states.q.size() < self_test_state_count; ++attempt) {
    VectorX q = start;
    const int reductions = attempt / 10;
    const VectorX offset = max_state_offset / (1 + reductions) * random_row(random, freedoms);
    VectorX x(freedoms);
    for (Eigen::Index u = 0; u < freedoms; ++u) {
      const auto column = static_cast<Eigen::Index>(program.independent[static_cast<std::size_t>(u)]);
      x[u] = q[column] + offset[u] * program.max_steps[static_cast<std::size_t>(u)] / max_step_fraction;
    }
    const VectorX dx = random_row(random, freedoms), ddx = random_row(random, freedoms);
    VectorX effort;
    if (!runner.follow(x, q) || !engine.assemble(q) || !engine.compute(q, dx, ddx, effort)) continue;
    const LoopProgramRunner::Motion motion = runner.move(q, dx, ddx);
    states.q.push_back(to_list(program.has_all_coordinates ? q : x));
    states.dq.push_back(to_list(program.has_all_coordinates ? motion.dq : dx));
    states.ddq.push_back(to_list(program.has_all_coordinates ? motion.ddq : ddx));
    states.torque.push_back(to_list(effort));
  }
  if (states.q.empty()) throw FormulaError("no state was found near the start at which the program can be tested");
  return states;
}

void check_loop_program(ProgramInterpreter& straight_line, Ring& ring, const SymbolicTree& tree,
                        const LoopProgram& program) {
  std::mt19937_64 random(1);
  const auto compare = [&](const Mechanism& mechanism) {
    assign_values(straight_line, ring);
    LoopInverseDynamics engine(drive_independent(remove_unmodelled_forces(mechanism), tree, program), tree, program);
    LoopProgramRunner runner(straight_line, program);
    VectorX q = Eigen::Map<const VectorX>(program.start.data(), static_cast<Eigen::Index>(program.columns)), effort;
    const auto freedoms = static_cast<Eigen::Index>(program.independent.size());
    const VectorX dx = random_row(random, freedoms), ddx = random_row(random, freedoms);
    if (!runner.close_loops(q) || !engine.assemble(q) || !engine.compute(q, dx, ddx, effort)) return false;
    TorqueDifference difference;
    difference.add(to_list(runner.move(q, dx, ddx).generalised), to_list(effort));
    if (!difference.is_within_tolerance()) throw FormulaError("the program differs from the engine");
    return true;
  };
  const ParametricModel& model = *tree.model;
  compare(model.build_mechanism(model.evaluate_nodes(model.inputs())));
  ParameterSampler(ring, model).compare_perturbed(perturbed_self_test_count, random, compare);
}

std::string comment_safe_title(const std::string& name) {
  std::string plain;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    plain += byte < 32 || byte > 126 || c == '*' || c == '/' || c == '\\' || c == '"' ? ' ' : c;
  }
  return plain.empty() ? "the mechanism" : plain;
}

}  // namespace balance::formulas
