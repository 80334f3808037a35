#include "balance/synthesis/formulas/program_code.hpp"

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/model/topology.hpp"
#include "balance/mechanics/model/validation.hpp"
#include "balance/synthesis/formulas/formula_parser.hpp"
#include "balance/synthesis/formulas/parameter_sampler.hpp"
#include "balance/synthesis/formulas/straight_line_program.hpp"
#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
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

/// @throws FormulaError
SelfTestStates make_self_test_states(const Mechanism& mechanism, const SymbolicTree& tree);

/// Compares the program with the engine at these states, and at single ones of them with other parameters and free
/// numbers.
/// @throws FormulaError if they differ
void check_program(ProgramInterpreter program, Ring& ring, const SymbolicTree& tree, const SelfTestStates& states);

/// A name that cannot end a comment.
std::string comment_safe_title(const std::string& name);

namespace {

/// The shortest decimal text of a number.
std::string shortest_decimal(double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  std::string number(text, end);
  if (number.find_first_of(".en") == std::string::npos) number += ".0";
  return number;
}

}  // namespace

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

/// Writes the nodes of a program in order.
class CodeWriter {
 public:
  CodeWriter(const StraightLineProgram& arena, const std::vector<int>& outputs, Language language)
      : arena_(arena), is_c_(language == Language::c), names_(arena.size()), uses_(arena.size(), 0) {
    std::vector<int> stack = outputs;
    std::vector<bool> is_visited(arena.size(), false);
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
    for (const int node : reachable_) store_constant_operands(node);
    for (const int output : outputs)
      if (!arena_[output].is_state_dependent) store_constant(output);
    for (const int node : reachable_)
      arena_[node].is_state_dependent ? write_state_dependent(node) : write_constant(node);
  }

  std::string reference(int node) const {
    const ProgramNode& self = arena_[node];
    return self.operation == ProgramOperation::constant ? number(self.value) : names_[as_index(node)];
  }
  const std::string& prepare() const { return prepare_; }
  const std::string& body() const { return body_; }
  std::size_t constants() const { return constant_slots_.size(); }
  CodeSize size() const { return size_; }
  std::string stored_reference(int node) const {
    const auto slot = constant_slots_.find(node);
    return slot == constant_slots_.end() ? reference(node) : "k[" + std::to_string(slot->second) + "]";
  }

 private:
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

std::string join_text(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

struct ProgramParts {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::pair<std::string, double>> numbers;
  std::string prepare, body;  ///< with the assignments of the torques
  std::size_t constants = 0;
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

std::string c_program(const ProgramParts& p) {
  std::string members, values;
  for (const auto& [name, value] : p.numbers) {
    members += "  double " + c_member_name(name) + ";\n";
    values += "  ." + c_member_name(name) + " = " + shortest_decimal(value) + ",\n";
  }
  const std::string n = std::to_string(p.columns.size()), k = std::to_string(std::max<std::size_t>(p.constants, 1));
  std::string text =
      "/* Torques of " + p.title +
      ": M(q) ddq + velocity terms + weight and springs [N m or N].\n   Coordinates: " + join_text(p.columns) +
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
      ": M(q) ddq + velocity terms + weight and springs [N m or N].\n\nCoordinates: " + join_text(p.columns) +
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

std::string generate_program(const Mechanism& mechanism, const study::SpecNumberTexts& texts, Language language,
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
    program.body += (c ? "  tau[" : "    tau[") + std::to_string(i) + "] = " + writer.stored_reference(outputs[i]) +
                    (c ? ";\n" : "\n");
  if (size != nullptr) *size = writer.size();
  std::string text = c ? c_program(program) : python_program(program);
  check_program(ProgramInterpreter(text, language, outputs.size()), ring, tree, program.states);
  return text;
}

namespace {

constexpr int self_test_state_count = 5;
constexpr std::size_t perturbed_self_test_count = 2;

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
Mechanism remove_loops(Mechanism mechanism, const SymbolicTree& tree) {
  const model::SpanningTree edges = model::build_spanning_tree(mechanism, {});
  for (const model::TreeEdge& edge : edges.edges)
    if (edge.split) split_body(mechanism, edge);
  mechanism.friction.clear();
  mechanism.loads.clear();
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
  for (const int c : tree.coordinates) mechanism.actuators.push_back(coordinate_id(c));
  return mechanism;
}

/// The engine's torques for a mechanism's spanning tree.
class TreeInverseDynamics {
 public:
  TreeInverseDynamics(const Mechanism& mechanism, const SymbolicTree& tree)
      : engine_(remove_loops(mechanism, tree), make_options(mechanism, tree)) {}

  std::vector<double> compute_torques(const std::vector<double>& q, const std::vector<double>& dq,
                                      const std::vector<double>& ddq) {
    const auto vector = [](const std::vector<double>& v) {
      return VectorX(Eigen::Map<const VectorX>(v.data(), static_cast<Eigen::Index>(v.size())));
    };
    VectorX effort;
    const MotionOutcome outcome = engine_.efforts(vector(q), vector(dq), vector(ddq), effort);
    if (outcome.status != MotionStatus::done) throw FormulaError("the engine has no torques to test the program with");
    return {effort.data(), effort.data() + effort.size()};
  }

 private:
  static InverseOptions make_options(const Mechanism& mechanism, const SymbolicTree& tree) {
    InverseOptions options;
    for (const int c : tree.coordinates)
      options.independent.push_back(mechanism.coordinates[static_cast<std::size_t>(c)].name);
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

/// @param numbers the ring with its current values
void assign_values(ProgramInterpreter& program, const Ring& numbers) {
  for (const Symbol& symbol : numbers.symbols()) program.set_parameter(symbol.name, symbol.value);
  for (const Angle& angle : numbers.angles()) program.set_parameter(angle.name, angle.value);
  program.prepare();
}

}  // namespace

SelfTestStates make_self_test_states(const Mechanism& mechanism, const SymbolicTree& tree) {
  SelfTestStates states;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  if (!tree.closures.empty()) states.meaning = "Loops are not closed: these are the torques of the spanning tree. ";
  states.meaning += "The test's torques are those of the program balance.";
  TreeInverseDynamics engine(mechanism, tree);
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

void check_program(ProgramInterpreter program, Ring& ring, const SymbolicTree& tree, const SelfTestStates& states) {
  assign_values(program, ring);
  TorqueDifference nominal_difference;
  for (std::size_t s = 0; s < states.q.size(); ++s)
    nominal_difference.add(program.compute_torques(states.q[s], states.dq[s], states.ddq[s]), states.torque[s]);
  if (!nominal_difference.is_within_tolerance()) throw FormulaError("the program differs from the engine");
  const ParameterSampler sampler(ring, *tree.model);
  if (!sampler.has_parameters()) return;
  std::mt19937_64 random(1);
  std::size_t s = 0;
  for (int draws = 0; s < perturbed_self_test_count && draws < ParameterSampler::max_draws; ++draws) {
    const std::vector<double> nodes = tree.model->evaluate_nodes(sampler.draw(random, draws));
    const Mechanism mechanism = tree.model->build_mechanism(nodes);
    if (!validate(mechanism).empty()) continue;
    const ScopedSymbolValues values(ring, nodes);
    assign_values(program, ring);
    TreeInverseDynamics engine(mechanism, tree);
    TorqueDifference perturbed_difference;
    perturbed_difference.add(program.compute_torques(states.q[s], states.dq[s], states.ddq[s]),
                             engine.compute_torques(states.q[s], states.dq[s], states.ddq[s]));
    ++s;
    if (!perturbed_difference.is_within_tolerance())
      throw FormulaError("the program differs from the engine at other numbers");
  }
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
