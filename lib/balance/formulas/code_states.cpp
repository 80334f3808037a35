#include "balance/formulas/code_states.hpp"

#include "balance/base/elementary.hpp"
#include "balance/formulas/newton_euler.hpp"
#include "balance/inverse/inverse_dynamics.hpp"
#include "balance/model/spanning_tree.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>

namespace balance::formulas {

namespace {

constexpr int state_count = 5;

/// The mechanism without its loops, friction and loads: what the program calculates, with a motor at every column. Nothing where a joint that
/// closes a loop is one of the tree's, too, which carries a copy of its body.
std::optional<Mechanism> tree_alone(Mechanism mechanism, const SymbolicTree& tree) {
  const SpanningTree edges = span(mechanism, {});
  if (std::any_of(edges.edges.begin(), edges.edges.end(), [](const TreeEdge& edge) { return edge.split; })) return {};
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

/// With plain numbers, for mechanisms whose loops the engine would close.
struct NumberMaker {
  const Ring& ring;
  std::map<int, double> angles, slides;

  double of(const Polynomial& p) const { return value_of(p); }
  double circular(int angle, bool sine) const {
    const auto moving = angles.find(angle);
    const double x = moving != angles.end() ? moving->second : ring.angle(angle).value;
    return sine ? elementary::sin(x) : elementary::cos(x);
  }
  double symbol(int index) const { return slides.at(index); }
};

std::vector<double> by_recursion(const Ring& ring, const SymbolicTree& tree, const std::vector<double>& q,
                                 const std::vector<double>& dq, const std::vector<double>& ddq) {
  NumberMaker make{ring, {}, {}};
  VariableRates<double> rates;
  for (const Variable& variable : tree.variables) {
    double x = variable.offset, v = 0, a = 0;
    for (const auto& [column, ratio] : variable.follows) {
      const double n = value_of(ratio);
      const auto c = static_cast<std::size_t>(column);
      x += n * q[c], v += n * dq[c], a += n * ddq[c];
    }
    (variable.is_angle ? make.angles : make.slides)[variable.index] = x;
    rates.rate.push_back(v), rates.acceleration.push_back(a);
  }
  return inverse_dynamics<double>(tree, make, rates);
}

}  // namespace

CodeStates code_states(const Mechanism& mechanism, Ring& ring, const SymbolicTree& tree) {
  CodeStates states;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  const std::optional<Mechanism> alone = tree_alone(mechanism, tree);
  if (!tree.closures.empty()) states.meaning = "Loops are not closed: these are the torques of the spanning tree. ";
  states.meaning +=
      alone ? "The test's torques are those of the program balance." : "The test's are those of its recursion.";
  if (!alone && tree.has_springs())
    throw FormulaError("springs beside a loop that an actuated joint closes have no program: it could not be tested");
  const std::size_t n = tree.columns.size();
  std::unique_ptr<InverseDynamics> engine;
  if (alone) {
    InverseOptions options;
    for (const int c : tree.coordinates)
      options.independent.push_back(mechanism.coordinates[static_cast<std::size_t>(c)].name);
    engine = std::make_unique<InverseDynamics>(*alone, options);
  }
  for (int s = 0; s < state_count; ++s) {
    const auto row = [&] {
      std::vector<double> values;
      for (std::size_t i = 0; i < n; ++i) values.push_back(any(random));
      return values;
    };
    const std::vector<double> q = row(), dq = row(), ddq = row();
    std::vector<double> torque;
    if (alone) {
      const auto vector = [](const std::vector<double>& v) {
        return VectorX(Eigen::Map<const VectorX>(v.data(), static_cast<Eigen::Index>(v.size())));
      };
      VectorX effort;
      const MotionOutcome outcome = engine->efforts(vector(q), vector(dq), vector(ddq), effort);
      if (outcome.status != MotionStatus::done)
        throw FormulaError("the engine has no torques to test the program with");
      torque.assign(effort.data(), effort.data() + effort.size());
    } else {
      torque = by_recursion(ring, tree, q, dq, ddq);
    }
    states.q.push_back(q), states.dq.push_back(dq), states.ddq.push_back(ddq), states.torque.push_back(torque);
  }
  return states;
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
