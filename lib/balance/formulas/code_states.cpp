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

constexpr int state_count = 5;
constexpr std::size_t program_states_elsewhere = 2;

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
Mechanism tree_alone(Mechanism mechanism, const SymbolicTree& tree) {
  const SpanningTree edges = span(mechanism, {});
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
  const auto move = [&](Followed& followed) {
    for (CoordinateTerm& term : followed.terms) term.coordinate = place(term.coordinate);
  };
  for (Coupling& coupling : mechanism.couplings) coupling.follower = place(coupling.follower), move(coupling.leader);
  for (Disc& disc : mechanism.discs) move(disc.follows);
  for (Spring& spring : mechanism.springs)
    if (spring.in_joint()) spring.coordinate = place(spring.coordinate);
  mechanism.actuators.clear();
  for (const int c : tree.coordinates) mechanism.actuators.push_back(place(c));
  return mechanism;
}

/// The engine's torques of a mechanism's spanning tree.
class TreeEngine {
 public:
  TreeEngine(const Mechanism& mechanism, const SymbolicTree& tree)
      : engine_(tree_alone(mechanism, tree), options_of(mechanism, tree)) {}

  std::vector<double> torques(const std::vector<double>& q, const std::vector<double>& dq,
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
  static InverseOptions options_of(const Mechanism& mechanism, const SymbolicTree& tree) {
    InverseOptions options;
    for (const int c : tree.coordinates)
      options.independent.push_back(mechanism.coordinates[static_cast<std::size_t>(c)].name);
    return options;
  }
  InverseDynamics engine_;
};

/// The largest difference at one state, and the largest torque.
struct Difference {
  double off = 0, scale = 0;

  void add(const std::vector<double>& found, const std::vector<double>& expected) {
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double d = std::abs(found[i] - expected[i]);
      off = std::isfinite(d) ? std::max(off, d) : std::numeric_limits<double>::infinity();
      scale = std::max(scale, std::abs(expected[i]));
    }
  }
  bool agrees() const { return off <= program_tolerance * scale; }
};

/// @param numbers whose values the ring has at present
void set_numbers(PrintedProgram& program, const Ring& numbers) {
  for (const Symbol& symbol : numbers.symbols()) program.set(symbol.name, symbol.value);
  for (const Angle& angle : numbers.angles()) program.set(angle.name, angle.value);
  program.prepare();
}

}  // namespace

CodeStates code_states(const Mechanism& mechanism, const SymbolicTree& tree) {
  CodeStates states;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  if (!tree.closures.empty()) states.meaning = "Loops are not closed: these are the torques of the spanning tree. ";
  states.meaning += "The test's torques are those of the program balance.";
  TreeEngine engine(mechanism, tree);
  for (int s = 0; s < state_count; ++s) {
    const auto row = [&] {
      std::vector<double> values;
      for (std::size_t i = 0; i < tree.columns.size(); ++i) values.push_back(any(random));
      return values;
    };
    const std::vector<double> q = row(), dq = row(), ddq = row();
    states.q.push_back(q), states.dq.push_back(dq), states.ddq.push_back(ddq);
    states.torque.push_back(engine.torques(q, dq, ddq));
  }
  return states;
}

void check_program(PrintedProgram program, Ring& ring, const SymbolicTree& tree, const CodeStates& states) {
  set_numbers(program, ring);
  Difference here;
  for (std::size_t s = 0; s < states.q.size(); ++s)
    here.add(program.torques(states.q[s], states.dq[s], states.ddq[s]), states.torque[s]);
  if (!here.agrees()) throw FormulaError("the program differs from the engine");
  const OtherNumbers numbers(ring, *tree.model);
  if (!numbers.exist()) return;
  std::mt19937_64 random(1);
  std::size_t s = 0;
  for (int draws = 0; s < program_states_elsewhere && draws < OtherNumbers::max_draws; ++draws) {
    const std::vector<double> nodes = tree.model->nodes_at(numbers.draw(random, draws));
    const Mechanism mechanism = tree.model->mechanism_at(nodes);
    if (!validate(mechanism).empty()) continue;
    const ValuesElsewhere values(ring, nodes);
    set_numbers(program, ring);
    TreeEngine engine(mechanism, tree);
    Difference elsewhere;
    elsewhere.add(program.torques(states.q[s], states.dq[s], states.ddq[s]),
                  engine.torques(states.q[s], states.dq[s], states.ddq[s]));
    ++s;
    if (!elsewhere.agrees()) throw FormulaError("the program differs from the engine at other numbers");
  }
}

std::string plain_title(const std::string& name) {
  std::string plain;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    plain += byte < 32 || byte > 126 || c == '*' || c == '/' || c == '\\' || c == '"' ? ' ' : c;
  }
  return plain.empty() ? "the mechanism" : plain;
}

}  // namespace balance::formulas
