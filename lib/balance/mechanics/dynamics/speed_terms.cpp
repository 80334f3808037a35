// The equation of motion in speeds. With σ = (speeds, constrained speeds) = W q̇ and q̇ = V σ, the accelerations are
// q̈ = V (σ̇ − N(q̇, q̇)), where N is the part of σ̇ quadratic in the rates. The work of the virtual speeds gives
// Vᵀ (M q̈ + w + z) = Vᵀ S u.

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/dynamics/equation_terms_impl.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <stdexcept>

namespace balance::dynamics {

// Speeds as rows over the rates of the independent coordinates, and the velocity-product part of their derivatives.

namespace {

/// A component of a body's velocity, or its derivative. Components of v in axes R that rotate at w have the derivative
/// Rᵀ (v̇ − w × v).
template <class S>
double compute_speed_component(const kinematics::TreeState<S>& state, const kinematics::FixedFrame<S>& body,
                               const model::GeneralisedSpeedTerm& term, bool derivative) {
  using enum model::GeneralisedSpeedTerm::Kind;
  const kinematics::NodeState<S>& node = state[static_cast<std::size_t>(body.node)];
  const Vector3 w = kinematics::angular_to_3d(typename S::Angular(node.R_WN * node.angular_velocity));
  Vector3 value;
  if (term.kind == angular_velocity || term.kind == angular_velocity_body) {
    value = derivative ? kinematics::angular_to_3d(typename S::Angular(node.R_WN * node.angular_acceleration)) : w;
  } else {
    const typename S::Vector p_N = body.p_N + body.R_N * kinematics::to_vector<S>(term.position);
    const Vector3 v = kinematics::to_3d(kinematics::point_velocity<S>(node, p_N));
    value = !derivative ? v : kinematics::to_3d(kinematics::point_acceleration<S>(node, p_N));
    if (derivative && term.kind == velocity_body) value -= w.cross(v);
  }
  const bool is_in_body_axes = term.kind == velocity_body || term.kind == angular_velocity_body;
  return is_in_body_axes ? to_matrix(orientation(state, body)).col(term.index).dot(value) : value[term.index];
}

/// @throws std::invalid_argument if a body, an axis or a coordinate cannot be used
template <class S>
void check_speeds(const Mechanism& mechanism, const kinematics::Tree<S>& tree,
                  const std::vector<model::GeneralisedSpeed>& speeds) {
  for (const model::GeneralisedSpeed& speed : speeds)
    for (const model::GeneralisedSpeedTerm& term : speed.terms) {
      if (term.kind != model::GeneralisedSpeedTerm::Kind::coordinate) {
        if (term.body < 0 || term.body >= static_cast<int>(tree.bodies.size()) || term.index < 0 || term.index > 2)
          throw std::invalid_argument("the speed " + speed.name + " refers to a body or an axis that does not exist");
        continue;
      }
      const auto c = static_cast<std::size_t>(term.index);
      const Coordinate& coordinate = mechanism.coordinates.at(c);
      if (!tree.coordinate_expressions[c].has_terms() || tree.is_floating[c])
        throw std::invalid_argument("the speed " + speed.name + " cannot contain " + coordinate.name +
                                    ", whose joint closes a loop or floats; make it independent or use others");
    }
}

/// @param dy rates, or accelerations, of the tree's coordinates @param state of the same motion
template <class S>
VectorX evaluate_speeds(const std::vector<model::GeneralisedSpeed>& speeds, const kinematics::Tree<S>& tree,
                        const double* dy, const kinematics::TreeState<S>& state, bool derivative) {
  VectorX values = VectorX::Zero(static_cast<Eigen::Index>(speeds.size()));
  for (std::size_t i = 0; i < speeds.size(); ++i)
    for (const model::GeneralisedSpeedTerm& term : speeds[i].terms)
      values[static_cast<Eigen::Index>(i)] +=
          term.factor *
          (term.kind == model::GeneralisedSpeedTerm::Kind::coordinate
               ? tree.coordinate_expressions[static_cast<std::size_t>(term.index)].rate(dy)
               : compute_speed_component(state, tree.bodies[static_cast<std::size_t>(term.body)], term, derivative));
  return values;
}

}  // namespace

template <class S>
MotionOutcome EquationTermsOf<S>::speed_rows(const double* q, const std::vector<model::GeneralisedSpeed>& speeds,
                                             MatrixX& rows, std::vector<MatrixX>& forms) {
  if (MotionOutcome outcome = move_to(q); outcome.status != MotionStatus::done) return outcome;
  const kinematics::Tree<S>& tree = branch_.tree();
  check_speeds(mechanism, tree, speeds);
  kinematics::TreeState<S>& state = branch_.state();
  rows.resize(static_cast<Eigen::Index>(speeds.size()), freedoms_);
  for (int k = 0; k < freedoms_; ++k) {
    const VectorX dy = C_.col(k);
    compute_velocities(tree, dy.data(), state);
    rows.col(k) = evaluate_speeds(speeds, tree, dy.data(), state, false);
  }
  forms = polarise_quadratic_form(freedoms_, [&](const VectorX& rates) {
    VectorX dy;
    const VectorX ddy = compute_velocity_product_acceleration(rates, dy);
    compute_velocities(tree, dy.data(), state);
    kinematics::compute_accelerations<S>(tree, dy.data(), ddy.data(), S::Vector::Zero(), state);
    return evaluate_speeds(speeds, tree, ddy.data(), state, true);
  });
  return {MotionStatus::done, 0, "", {}};
}

template MotionOutcome EquationTermsOf<kinematics::Planar>::speed_rows(const double*,
                                                                       const std::vector<model::GeneralisedSpeed>&,
                                                                       MatrixX&, std::vector<MatrixX>&);
template MotionOutcome EquationTermsOf<kinematics::Spatial>::speed_rows(const double*,
                                                                        const std::vector<model::GeneralisedSpeed>&,
                                                                        MatrixX&, std::vector<MatrixX>&);

namespace {

constexpr double inverse_condition_tolerance = 1e-9;  ///< smallest over largest singular value of a singular matrix

/// Whether the rows are regular: they are normalised, and columns that are lengths are scaled by the characteristic
/// length.
bool is_regular(MatrixX rows, const Mechanism& mechanism, const std::vector<CoordinateId>& independent) {
  for (std::size_t k = 0; k < independent.size(); ++k)
    if (mechanism.coordinates[static_cast<std::size_t>(independent[k])].kind == CoordinateKind::length)
      rows.col(static_cast<Eigen::Index>(k)) *= characteristic_length(mechanism);
  for (Eigen::Index r = 0; r < rows.rows(); ++r) rows.row(r).stableNormalize();
  if (!rows.allFinite()) return false;
  const VectorX values = numerics::singular_values(rows);
  return values.size() == 0 || values[values.size() - 1] > inverse_condition_tolerance * values[0];
}

bool is_finite(const IndependentTerms& terms) {
  for (const MatrixX& form : terms.velocity)
    if (!form.allFinite()) return false;
  return terms.mass.allFinite() && terms.viscous.allFinite() && terms.static_terms.sum().allFinite() &&
         terms.input.allFinite();
}

/// `count` rows, from `first` on, of the equation for all of σ.
IndependentTerms select_rows(const IndependentTerms& equations, Eigen::Index first, Eigen::Index count) {
  IndependentTerms out;
  out.mass = equations.mass.middleRows(first, count);
  out.velocity.assign(equations.velocity.begin() + first, equations.velocity.begin() + first + count);
  out.viscous = equations.viscous.middleRows(first, count);
  out.static_terms = {equations.static_terms.weight.segment(first, count),
                      equations.static_terms.springs.segment(first, count),
                      equations.static_terms.loads.segment(first, count)};
  out.input = equations.input.middleRows(first, count);
  return out;
}

/// @param V d×d @param forms N @param s number of speeds that are not constrained
IndependentTerms project_on_speeds(const IndependentTerms& terms, const MatrixX& V, const std::vector<MatrixX>& forms,
                                   Eigen::Index s) {
  const MatrixX V_speeds = V.leftCols(s), inertia = V.transpose() * terms.mass * V;
  IndependentTerms projected;
  projected.mass = inertia.leftCols(s);
  for (Eigen::Index k = 0; k < V.cols(); ++k) {
    MatrixX form = MatrixX::Zero(V.rows(), V.rows());
    for (Eigen::Index a = 0; a < V.rows(); ++a)
      form +=
          V(a, k) * terms.velocity[static_cast<std::size_t>(a)] - inertia(k, a) * forms[static_cast<std::size_t>(a)];
    projected.velocity.push_back(V_speeds.transpose() * form * V_speeds);
  }
  projected.viscous = V.transpose() * terms.viscous * V_speeds;
  projected.static_terms = {V.transpose() * terms.static_terms.weight, V.transpose() * terms.static_terms.springs,
                            V.transpose() * terms.static_terms.loads};
  projected.input = V.transpose() * terms.input;
  return projected;
}

}  // namespace

Expected<SpeedTerms> EquationTerms::speed_terms(const VectorX& q, const model::SpeedChoice& choice, double time) {
  const auto d = static_cast<Eigen::Index>(engine_->independent.size());
  const auto s = static_cast<Eigen::Index>(choice.speeds.size()),
             p = static_cast<Eigen::Index>(choice.constrained.size());
  if (s == 0 || s + p != d)
    throw std::invalid_argument("speeds, free and held at zero, must be as many as the degrees of freedom, " +
                                std::to_string(d) + "; they are " + std::to_string(s) + " and " + std::to_string(p));
  const Expected<IndependentTerms> terms = independent_terms(q, time);
  Expected<SpeedTerms> result;
  result.outcome = terms.outcome;
  if (!terms) return result;
  std::vector<model::GeneralisedSpeed> all_speeds = choice.speeds;
  all_speeds.insert(all_speeds.end(), choice.constrained.begin(), choice.constrained.end());
  std::vector<MatrixX> forms;
  result.outcome = engine_->speed_rows(q.data(), all_speeds, result.value.rows, forms);
  if (!result) return result;
  if (!is_regular(result.value.rows, engine_->mechanism, engine_->independent)) {
    result.outcome = {MotionStatus::drive_singularity,
                      time,
                      p == 0 ? "the speeds do not determine the mechanism's motion there"
                             : "the speeds and those held at zero do not determine the mechanism's motion there",
                      {}};
    return result;
  }
  const MatrixX V = result.value.rows.partialPivLu().inverse();
  const IndependentTerms all_equations = project_on_speeds(terms.value, V, forms, s);
  if (!is_finite(all_equations)) {
    result.outcome = trajectory::make_overflow_outcome(time, "the equation of motion", engine_->mechanism);
    return result;
  }
  result.value.rates = V.leftCols(s);
  result.value.speed_equations = select_rows(all_equations, 0, s);
  result.value.constraint_equations = select_rows(all_equations, s, p);
  return result;
}

}  // namespace balance::dynamics
