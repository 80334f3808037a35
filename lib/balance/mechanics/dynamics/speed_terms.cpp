// The equation of motion in speeds. With σ = (speeds, constrained speeds) = W q̇ and q̇ = V σ, the accelerations are
// q̈ = V (σ̇ − N(q̇, q̇)), where N is the part of σ̇ quadratic in the rates. The work of the virtual speeds gives
// Vᵀ (M q̈ + w + z) = Vᵀ S u.

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/dynamics/equation_terms_impl.hpp"
#include "balance/mechanics/dynamics/speed_probe.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <stdexcept>

namespace balance::dynamics {

template <class S>
MotionOutcome EquationTermsOf<S>::speed_rows(const double* q, double time,
                                             const std::vector<model::GeneralisedSpeed>& speeds, MatrixX& rows,
                                             VectorX& offset, RateFunctions& products) {
  if (MotionOutcome outcome = move_to(q, time); outcome.status != MotionStatus::done) return outcome;
  const kinematics::Tree<S>& tree = branch_.tree();
  check_speeds(mechanism, tree, speeds);
  kinematics::TreeState<S>& state = branch_.state();
  const auto values_at = [&](const VectorX& dy) {
    compute_velocities(tree, dy.data(), state);
    return SpeedProbe<S>{tree, state, branch_.y(), dy.data(), nullptr}.evaluate_speeds(speeds, false);
  };
  rows.resize(static_cast<Eigen::Index>(speeds.size()), freedoms_);
  for (int k = 0; k < freedoms_; ++k) rows.col(k) = values_at(C_.col(k));
  VectorX dy;
  if (has_prescribed_speeds_) {
    compute_velocity_product_acceleration(VectorX::Zero(freedoms_), dy);
    offset = values_at(dy);
  }
  products = expand_in_rates(freedoms_, !has_prescribed_speeds_, [&](const VectorX& rates) {
    const VectorX ddy = compute_velocity_product_acceleration(rates, dy);
    compute_velocities(tree, dy.data(), state);
    kinematics::compute_accelerations<S>(tree, dy.data(), ddy.data(), S::Vector::Zero(), state);
    return SpeedProbe<S>{tree, state, branch_.y(), dy.data(), ddy.data()}.evaluate_speeds(speeds, true);
  });
  return {MotionStatus::done, 0, "", {}};
}

template MotionOutcome EquationTermsOf<kinematics::Planar>::speed_rows(const double*, double,
                                                                       const std::vector<model::GeneralisedSpeed>&,
                                                                       MatrixX&, VectorX&, RateFunctions&);
template MotionOutcome EquationTermsOf<kinematics::Spatial>::speed_rows(const double*, double,
                                                                        const std::vector<model::GeneralisedSpeed>&,
                                                                        MatrixX&, VectorX&, RateFunctions&);

namespace {

constexpr double inverse_condition_tolerance = 1e-9;  ///< smallest over largest singular value of a singular matrix

/// The rows normalised, with columns that are lengths scaled by the characteristic length.
MatrixX normalise_rows(MatrixX rows, const Mechanism& mechanism, const std::vector<CoordinateId>& independent) {
  for (std::size_t k = 0; k < independent.size(); ++k)
    if (mechanism.coordinates[static_cast<std::size_t>(independent[k])].kind == CoordinateKind::length)
      rows.col(static_cast<Eigen::Index>(k)) *= characteristic_length(mechanism);
  for (Eigen::Index r = 0; r < rows.rows(); ++r) rows.row(r).stableNormalize();
  return rows;
}

bool is_regular(const MatrixX& rows) {
  if (!rows.allFinite()) return false;
  const VectorX values = numerics::singular_values(rows);
  return values.size() == 0 || values[values.size() - 1] > inverse_condition_tolerance * values[0];
}

/// The first speeds that determine the motion together with the constrained ones.
/// @param rows normalised: all speeds, then the constrained ones
/// @return d − p indices; fewer if they do not suffice
std::vector<int> choose_independent_speeds(const MatrixX& rows, Eigen::Index speeds) {
  const Eigen::Index d = rows.cols(), constrained = rows.rows() - speeds;
  std::vector<int> chosen;
  MatrixX taken = rows.bottomRows(constrained);
  for (Eigen::Index r = 0; r < speeds && taken.rows() < d; ++r) {
    MatrixX candidate(taken.rows() + 1, d);
    candidate << taken, rows.row(r);
    const bool is_last_chance = speeds - r == d - taken.rows();  // whatever is wrong is found below
    if (!is_last_chance && !is_regular(candidate)) continue;
    taken = candidate;
    chosen.push_back(static_cast<int>(r));
  }
  return chosen;
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
                      equations.static_terms.loads.segment(first, count),
                      {}};
  if (equations.static_terms.prescribed.size() > 0)
    out.static_terms.prescribed = equations.static_terms.prescribed.segment(first, count);
  out.input = equations.input.middleRows(first, count);
  return out;
}

/// @param V d×d, the independent speeds first @param products N of the same speeds
/// @param offset of the rates of the coordinates; empty: zero
/// @param s number of speeds that are not constrained
IndependentTerms project_on_speeds(const IndependentTerms& terms, const MatrixX& V, const RateFunctions& products,
                                   const VectorX& offset, Eigen::Index s) {
  const MatrixX V_speeds = V.leftCols(s), inertia = V.transpose() * terms.mass * V;
  RateFunctions forces;  // of the rates of the coordinates, without friction
  for (Eigen::Index k = 0; k < V.cols(); ++k) {
    MatrixX form = MatrixX::Zero(V.rows(), V.rows());
    for (Eigen::Index a = 0; a < V.rows(); ++a)
      form += V(a, k) * terms.velocity[static_cast<std::size_t>(a)] -
              inertia(k, a) * products.quadratic[static_cast<std::size_t>(a)];
    forces.quadratic.push_back(std::move(form));
  }
  if (offset.size() > 0) {
    forces.linear = V.transpose() * terms.viscous - inertia * products.linear;
    forces.constant = -inertia * products.constant;
    if (terms.static_terms.prescribed.size() > 0) forces.constant += V.transpose() * terms.static_terms.prescribed;
  }
  RateFunctions in_speeds = forces.substitute(V_speeds, offset);
  IndependentTerms projected;
  projected.mass = inertia.leftCols(s);
  projected.velocity = std::move(in_speeds.quadratic);
  projected.viscous = offset.size() > 0 ? in_speeds.linear : MatrixX(V.transpose() * terms.viscous * V_speeds);
  projected.static_terms = {V.transpose() * terms.static_terms.weight, V.transpose() * terms.static_terms.springs,
                            V.transpose() * terms.static_terms.loads, in_speeds.constant};
  projected.input = V.transpose() * terms.input;
  return projected;
}

/// Rows of functions.
RateFunctions select_functions(const RateFunctions& functions, const std::vector<int>& rows) {
  RateFunctions out;
  for (const int row : rows) out.quadratic.push_back(functions.quadratic[static_cast<std::size_t>(row)]);
  if (functions.linear.size() == 0) return out;
  out.linear = functions.linear(rows, Eigen::all);
  out.constant = functions.constant(rows);
  return out;
}

/// Replaces constrained speeds, which come last, by their differences from the values that they have.
void subtract_values(const std::vector<model::GeneralisedSpeed>& constrained, double time, VectorX& offset,
                     RateFunctions& products) {
  const auto count = static_cast<Eigen::Index>(products.quadratic.size()),
             first = count - static_cast<Eigen::Index>(constrained.size());
  for (std::size_t k = 0; k < constrained.size(); ++k) {
    if (!constrained[k].value) continue;
    if (offset.size() == 0) {
      offset.setZero(count);
      products.linear.setZero(count, products.quadratic.front().cols());
      products.constant.setZero(count);
    }
    const model::ValueAndRate value = evaluate_at_time(constrained[k].value, time);
    offset[first + static_cast<Eigen::Index>(k)] -= value.value;
    products.constant[first + static_cast<Eigen::Index>(k)] -= value.rate;
  }
}

std::string not_determined_reason(Eigen::Index constrained) {
  return constrained == 0 ? "the speeds do not determine the mechanism's motion there"
                          : "the speeds and those held at zero do not determine the mechanism's motion there";
}

/// All speeds π = W q̇ + w₀ and their derivatives in the independent ones: π = W (V σ + o) + w₀, and π̇ = W q̈ + N with
/// q̈ = V (σ̇ − N of the independent and constrained ones).
void relate_speeds(const RateFunctions& products, const RateFunctions& basis_products, const MatrixX& V,
                   SpeedTerms& terms) {
  const auto s = static_cast<Eigen::Index>(terms.independent.size());
  const auto count = terms.rows.rows() - (V.rows() - s);
  const MatrixX gain = terms.rows.topRows(count) * V;
  terms.transformation = gain.leftCols(s);
  RateFunctions of_rates;
  for (Eigen::Index i = 0; i < count; ++i) {
    MatrixX form = products.quadratic[static_cast<std::size_t>(i)];
    for (Eigen::Index a = 0; a < V.cols(); ++a)
      form -= gain(i, a) * basis_products.quadratic[static_cast<std::size_t>(a)];
    of_rates.quadratic.push_back(std::move(form));
  }
  if (products.linear.size() > 0) {
    of_rates.linear = products.linear.topRows(count) - gain * basis_products.linear;
    of_rates.constant = products.constant.head(count) - gain * basis_products.constant;
  }
  RateFunctions in_speeds = of_rates.substitute(V.leftCols(s), terms.rate_offset);
  terms.acceleration = std::move(in_speeds.quadratic);
  terms.acceleration_linear = std::move(in_speeds.linear);
  terms.acceleration_offset = std::move(in_speeds.constant);
  for (std::size_t k = 0; k < terms.independent.size(); ++k) {  // exactly
    const int i = terms.independent[k];
    terms.transformation.row(i) = VectorX::Unit(s, static_cast<Eigen::Index>(k)).transpose();
    terms.acceleration[static_cast<std::size_t>(i)].setZero();
    if (terms.acceleration_linear.size() == 0) continue;
    terms.acceleration_linear.row(i).setZero();
    terms.acceleration_offset[i] = 0;
  }
}

}  // namespace

Expected<SpeedTerms> EquationTerms::speed_terms(const VectorX& q, const model::SpeedChoice& choice, double time) {
  const auto d = static_cast<Eigen::Index>(engine_->independent.size());
  const auto count = static_cast<Eigen::Index>(choice.speeds.size()),
             p = static_cast<Eigen::Index>(choice.constrained.size());
  if (count == 0 || count + p < d)
    throw std::invalid_argument("speeds, free and held, must be at least as many as the degrees of freedom, " +
                                std::to_string(d) + "; they are " + std::to_string(count) + " and " +
                                std::to_string(p));
  if (p >= d)
    throw std::invalid_argument("speeds that are held must be fewer than the degrees of freedom, " + std::to_string(d) +
                                "; they are " + std::to_string(p));
  const Expected<IndependentTerms> terms = independent_terms(q, time);
  Expected<SpeedTerms> result;
  result.outcome = terms.outcome;
  if (!terms) return result;
  std::vector<model::GeneralisedSpeed> all_speeds = choice.speeds;
  all_speeds.insert(all_speeds.end(), choice.constrained.begin(), choice.constrained.end());
  SpeedTerms& found = result.value;
  VectorX row_offset;
  RateFunctions products;
  result.outcome = engine_->speed_rows(q.data(), time, all_speeds, found.rows, row_offset, products);
  if (!result) return result;
  subtract_values(choice.constrained, time, row_offset, products);
  const MatrixX normalised = normalise_rows(found.rows, engine_->mechanism, engine_->independent);
  found.independent = choose_independent_speeds(normalised, count);
  std::vector<int> basis = found.independent;
  for (Eigen::Index k = 0; k < p; ++k) basis.push_back(static_cast<int>(count + k));
  if (static_cast<Eigen::Index>(basis.size()) < d || !is_regular(normalised(basis, Eigen::all))) {
    result.outcome = {MotionStatus::drive_singularity, time, not_determined_reason(p), {}};
    return result;
  }
  const MatrixX V = MatrixX(found.rows(basis, Eigen::all)).partialPivLu().inverse();
  if (row_offset.size() > 0) found.rate_offset = -V * row_offset(basis);
  const Eigen::Index s = d - p;
  const RateFunctions basis_products = select_functions(products, basis);
  const IndependentTerms all_equations = project_on_speeds(terms.value, V, basis_products, found.rate_offset, s);
  if (!is_finite(all_equations)) {
    result.outcome = trajectory::make_overflow_outcome(time, "the equation of motion", engine_->mechanism);
    return result;
  }
  found.rates = V.leftCols(s);
  relate_speeds(products, basis_products, V, found);
  if (row_offset.size() > 0)
    found.speed_offset = row_offset.head(count) + found.rows.topRows(count) * found.rate_offset;
  found.speed_equations = select_rows(all_equations, 0, s);
  found.constraint_equations = select_rows(all_equations, s, p);
  return result;
}

}  // namespace balance::dynamics
