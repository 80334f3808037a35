#include "balance/formulas/code_states.hpp"

#include "balance/formulas/other_numbers.hpp"
#include "balance/inverse/inverse_dynamics.hpp"
#include "balance/model/spanning_tree.hpp"
#include "balance/model/validate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

namespace balance::formulas {

namespace {

constexpr int self_test_state_count = 5;
constexpr std::size_t perturbed_self_test_count = 2;

/// Round-off of a program is far below, a wrong term far above.
constexpr double program_tolerance = 1e-9;

/// A tree's joint that closes a loop carries a massless copy of its body.
void split_body(Mechanism& mechanism, const TreeEdge& edge) {
  Joint& joint = mechanism.joints[static_cast<std::size_t>(edge.joint)];
  BodyId& end = edge.forward ? joint.second : joint.first;
  Body copy{.name = "copy " + std::to_string(mechanism.bodies.size())};
  end = static_cast<int>(mechanism.bodies.size());
  mechanism.bodies.push_back(std::move(copy));
}

/// The mechanism without its loops, friction and loads: what the program calculates, with a motor at every column.
Mechanism remove_loops(Mechanism mechanism, const SymbolicTree& tree) {
  const SpanningTree edges = build_spanning_tree(mechanism, {});
  for (const TreeEdge& edge : edges.edges)
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
  std::map<std::string, int> places;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    places.emplace(mechanism.coordinates[c].name, static_cast<int>(c));
  const auto place = [&](int c) { return places.at(coordinates[static_cast<std::size_t>(c)].name); };
  const auto move = [&](CoordinateCombination& followed) {
    for (CoordinateTerm& term : followed.terms) term.coordinate = place(term.coordinate);
  };
  for (Coupling& coupling : mechanism.couplings) coupling.follower = place(coupling.follower), move(coupling.leader);
  for (Disc& disc : mechanism.discs) move(disc.follows);
  for (Spring& spring : mechanism.springs)
    if (spring.is_joint_spring()) spring.coordinate = place(spring.coordinate);
  mechanism.actuators.clear();
  for (const int c : tree.coordinates) mechanism.actuators.push_back(place(c));
  return mechanism;
}

/// The engine's torques of a mechanism's spanning tree.
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

/// The largest difference at one state, and the largest torque.
struct TorqueDifference {
  double max_error = 0, max_torque = 0;

  void add(const std::vector<double>& found, const std::vector<double>& expected) {
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double d = std::abs(found[i] - expected[i]);
      max_error = std::isfinite(d) ? std::max(max_error, d) : std::numeric_limits<double>::infinity();
      max_torque = std::max(max_torque, std::abs(expected[i]));
    }
  }
  bool is_within_tolerance() const { return max_error <= program_tolerance * max_torque; }
};

/// @param numbers whose values the ring has at present
void assign_values(ProgramInterpreter& program, const Ring& numbers) {
  for (const Symbol& symbol : numbers.symbols()) program.set_parameter(symbol.name, symbol.value);
  for (const Angle& angle : numbers.angles()) program.set_parameter(angle.name, angle.value);
  program.prepare();
}

}  // namespace

SelfTestStates make_self_test_states(const Mechanism& mechanism, const SymbolicTree& tree) {
  SelfTestStates states;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  if (!tree.closures.empty()) states.meaning = "Loops are not closed: these are the torques of the spanning tree. ";
  states.meaning += "The test's torques are those of the program balance.";
  TreeInverseDynamics engine(mechanism, tree);
  for (int s = 0; s < self_test_state_count; ++s) {
    const auto row = [&] {
      std::vector<double> values;
      for (std::size_t i = 0; i < tree.columns.size(); ++i) values.push_back(any(random));
      return values;
    };
    const std::vector<double> q = row(), dq = row(), ddq = row();
    states.q.push_back(q), states.dq.push_back(dq), states.ddq.push_back(ddq);
    states.torque.push_back(engine.compute_torques(q, dq, ddq));
  }
  return states;
}

void check_program(ProgramInterpreter program, Ring& ring, const SymbolicTree& tree, const SelfTestStates& states) {
  assign_values(program, ring);
  TorqueDifference here;
  for (std::size_t s = 0; s < states.q.size(); ++s)
    here.add(program.compute_torques(states.q[s], states.dq[s], states.ddq[s]), states.torque[s]);
  if (!here.is_within_tolerance()) throw FormulaError("the program differs from the engine");
  const ParameterSampler numbers(ring, *tree.model);
  if (!numbers.has_parameters()) return;
  std::mt19937_64 random(1);
  std::size_t s = 0;
  for (int draws = 0; s < perturbed_self_test_count && draws < ParameterSampler::max_draws; ++draws) {
    const std::vector<double> nodes = tree.model->evaluate_nodes(numbers.draw(random, draws));
    const Mechanism mechanism = tree.model->build_mechanism(nodes);
    if (!validate(mechanism).empty()) continue;
    const ScopedSymbolValues values(ring, nodes);
    assign_values(program, ring);
    TreeInverseDynamics engine(mechanism, tree);
    TorqueDifference elsewhere;
    elsewhere.add(program.compute_torques(states.q[s], states.dq[s], states.ddq[s]),
                  engine.compute_torques(states.q[s], states.dq[s], states.ddq[s]));
    ++s;
    if (!elsewhere.is_within_tolerance()) throw FormulaError("the program differs from the engine at other numbers");
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
