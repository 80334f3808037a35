#include "balance/formulas/code_states.hpp"

#include "balance/formulas/newton_euler.hpp"
#include "balance/inverse/inverse_dynamics.hpp"

#include <cmath>
#include <random>

namespace balance::formulas {

namespace {

constexpr int state_count = 5;

/// The mechanism without its loops, friction and loads: what the program calculates.
Mechanism open_tree(Mechanism mechanism, const SymbolicTree& tree) {
  mechanism.friction.clear();
  mechanism.loads.clear();
  mechanism.actuators = tree.coordinates;
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
    return sine ? std::sin(x) : std::cos(x);
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
  const bool open = tree.closures.empty();
  states.meaning =
      open ? "The test's torques are those of the program balance."
           : "Loops are not closed: these are the torques of the spanning tree, the test's those of its recursion.";
  if (!open && tree.has_springs())
    throw FormulaError("springs in a mechanism with loops have no program yet: it could not be tested");
  const std::size_t n = tree.columns.size();
  std::unique_ptr<InverseDynamics> engine;
  if (open) {
    InverseOptions options;
    for (const int c : tree.coordinates)
      options.independent.push_back(mechanism.coordinates[static_cast<std::size_t>(c)].name);
    engine = std::make_unique<InverseDynamics>(open_tree(mechanism, tree), options);
  }
  for (int s = 0; s < state_count; ++s) {
    const auto row = [&] {
      std::vector<double> values;
      for (std::size_t i = 0; i < n; ++i) values.push_back(any(random));
      return values;
    };
    const std::vector<double> q = row(), dq = row(), ddq = row();
    std::vector<double> torque;
    if (open) {
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
