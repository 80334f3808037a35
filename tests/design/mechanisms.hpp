#pragma once
/// Mechanisms with free numbers, built without a spec.

#include "balance/synthesis/design/solve_design.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace design_tests {

using namespace balance;
using namespace balance::design;

inline model::NamedPoint at(const std::string& name, double x, double y) { return {name, {x, y, 0}}; }

inline Matrix3 about_z(double j) { return Vector3(0, 0, j).asDiagonal(); }

inline Joint revolute(const std::string& name, int first, int second, const Vector3& point_first,
                      const Vector3& point_second = Vector3::Zero()) {
  Joint joint;
  joint.name = name;
  joint.first = first;
  joint.second = second;
  joint.point_first = point_first;
  joint.point_second = point_second;
  return joint;
}

/// Serial arm in the plane: links of the given lengths along x, all joints revolute and driven.
inline Mechanism planar_arm(const std::vector<double>& lengths, const std::vector<double>& masses,
                            double gravity = -9.81) {
  Mechanism m;
  m.gravity = {0, gravity, 0};
  m.bodies.push_back({"ground", 0, Vector3::Zero(), Matrix3::Zero(), {at("origin", 0, 0)}});
  for (std::size_t k = 0; k < lengths.size(); ++k) {
    const std::string number = std::to_string(k + 1);
    m.bodies.push_back({"link" + number,
                        masses[k],
                        {lengths[k] / 2, 0, 0},
                        about_z(masses[k] * lengths[k] * lengths[k] / 12),
                        {at("A", 0, 0), at("B", lengths[k], 0)}});
    m.joints.push_back(
        revolute("J" + number, static_cast<int>(k), static_cast<int>(k) + 1, {k == 0 ? 0 : lengths[k - 1], 0, 0}));
  }
  m.coordinates = list_coordinates(m.space, m.joints);
  for (std::size_t k = 0; k < lengths.size(); ++k) m.actuators.push_back(static_cast<int>(k));
  return m;
}

inline Attachment counterweight(const std::string& name, int body, double x, double y, double mass) {
  Attachment a;
  a.name = name;
  a.body = body;
  a.position = {x, y, 0};
  a.mass = mass;
  return a;
}

inline Disc disc(const std::string& name, int body, double x, int follows, double ratio, double mass, double inertia) {
  Disc d;
  d.name = name;
  d.body = body;
  d.position = {x, 0, 0};
  d.follows = follows;
  d.ratio = ratio;
  d.mass = mass;
  d.inertia = about_z(inertia);
  return d;
}

/// Slider-crank: crank of 0.1 m, rod of 0.3 m, slider along x.
inline Mechanism slider_crank() {
  Mechanism m;
  m.bodies = {{"ground", 0, Vector3::Zero(), Matrix3::Zero(), {at("O", 0, 0)}},
              {"crank", 0.4, {0.05, 0, 0}, about_z(0.001), {at("A", 0, 0), at("B", 0.1, 0)}},
              {"rod", 0.2, {0.15, 0, 0}, about_z(0.002), {at("B", 0, 0), at("C", 0.3, 0)}},
              {"slider", 0.1, {0, 0, 0}, about_z(0.0001), {at("C", 0, 0)}}};
  Joint slide;
  slide.name = "S";
  slide.type = JointType::prismatic;
  slide.second = 3;
  slide.axis = Vector3::UnitX();
  m.joints = {revolute("A", 0, 1, Vector3::Zero()), revolute("B", 1, 2, {0.1, 0, 0}), revolute("C", 2, 3, {0.3, 0, 0}),
              slide};
  m.coordinates = list_coordinates(m.space, m.joints);
  m.actuators = {0};
  m.assembly = {{0, 0.3}, {1, -0.4}, {3, 0.39}};
  return m;
}

/// A model of nothing but a mechanism.
class MechanismModel final : public DesignModel {
 public:
  explicit MechanismModel(std::function<Mechanism(const VectorX&)> mechanism_at)
      : mechanism_at_(std::move(mechanism_at)) {}
  Mechanism build_mechanism(const VectorX& x) const override { return mechanism_at_(x); }

 private:
  std::function<Mechanism(const VectorX&)> mechanism_at_;
};

inline std::shared_ptr<const DesignModel> model_of(std::function<Mechanism(const VectorX&)> mechanism_at) {
  return std::make_shared<const MechanismModel>(std::move(mechanism_at));
}

inline DesignProblem problem(std::vector<DesignVariable> variables,
                             std::function<Mechanism(const VectorX&)> mechanism_at, GoalKind goal) {
  DesignProblem p;
  p.variables = std::move(variables);
  p.model = model_of(std::move(mechanism_at));
  p.goals = {{goal, false}};
  return p;
}

/// A link of 2 kg whose CoM lies at 0.25 with two counterweights of free mass: 0.2 a + 0.4 b = 0.5 balances it.
inline DesignProblem two_counterweights(const DesignVariable& a = {"a", 0, 10, 1},
                                        const DesignVariable& b = {"b", 0, 10, 1}) {
  return problem(
      {a, b},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5}, {2});
        m.attachments = {counterweight("a", 1, -0.2, 0, x[0]), counterweight("b", 1, -0.4, 0, x[1])};
        return m;
      },
      GoalKind::statics);
}

/// Largest size of what the conditions of the mechanism at x leave; derived anew.
inline double judged(const DesignProblem& p, const VectorX& x) {
  const Mechanism mechanism = p.model->build_mechanism(x);
  ConditionOptions options = p.options;
  options.seed = 77;  // other configurations than the design saw
  const Conditions conditions = derive_conditions(mechanism, p.goals, options);
  if (conditions.status != ConditionsStatus::done) return 1e9;
  const VectorX residual = scaled_residuals(conditions, dynamics::parameter_values(mechanism, options.loose_springs));
  return residual.size() > 0 ? residual.cwiseAbs().maxCoeff() : 0;
}

inline bool within_bounds(const DesignProblem& p, const VectorX& x) {
  for (std::size_t i = 0; i < p.variables.size(); ++i)
    if (!(x[static_cast<Eigen::Index>(i)] >= p.variables[i].lower &&
          x[static_cast<Eigen::Index>(i)] <= p.variables[i].upper))
      return false;
  return true;
}

}  // namespace design_tests
