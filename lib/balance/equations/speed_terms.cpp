// The equation of motion in speeds: with σ = (speeds, zeros) = W q̇ and q̇ = V σ the accelerations are q̈ = V (σ̇ − N(q̇, q̇)), N being what
// rates alone make of σ̇, and the virtual speeds' work is Vᵀ (M q̈ + w + z) = Vᵀ S u.

#include "balance/base/factorizations.hpp"
#include "balance/equations/engine.hpp"
#include "balance/motion/wording.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <stdexcept>

namespace balance {

namespace {

constexpr double inverse_condition_tolerance = 1e-9;  ///< of the largest singular value: what counts as no inverse

/// Rows of any unit, columns in characteristic lengths.
bool is_regular(MatrixX rows, const Mechanism& mechanism, const std::vector<CoordinateId>& independent) {
  for (std::size_t k = 0; k < independent.size(); ++k)
    if (mechanism.coordinates[static_cast<std::size_t>(independent[k])].kind == CoordinateKind::length)
      rows.col(static_cast<Eigen::Index>(k)) *= characteristic_length(mechanism);
  for (Eigen::Index r = 0; r < rows.rows(); ++r) rows.row(r).stableNormalize();
  if (!rows.allFinite()) return false;
  const VectorX values = singular_values(rows);
  return values.size() == 0 || values[values.size() - 1] > inverse_condition_tolerance * values[0];
}

bool is_finite(const IndependentTerms& terms) {
  for (const MatrixX& form : terms.velocity)
    if (!form.allFinite()) return false;
  return terms.mass.allFinite() && terms.viscous.allFinite() && terms.static_terms.sum().allFinite() &&
         terms.input.allFinite();
}

/// Rows `first` on of the equation for all of σ.
IndependentTerms select_rows(const IndependentTerms& all, Eigen::Index first, Eigen::Index count) {
  IndependentTerms out;
  out.mass = all.mass.middleRows(first, count);
  out.velocity.assign(all.velocity.begin() + first, all.velocity.begin() + first + count);
  out.viscous = all.viscous.middleRows(first, count);
  out.static_terms = {all.static_terms.weight.segment(first, count), all.static_terms.springs.segment(first, count),
                      all.static_terms.loads.segment(first, count)};
  out.input = all.input.middleRows(first, count);
  return out;
}

/// @param V d×d @param forms N @param s how many of σ move
IndependentTerms project_on_speeds(const IndependentTerms& terms, const MatrixX& V, const std::vector<MatrixX>& forms,
                                   Eigen::Index s) {
  const MatrixX moving = V.leftCols(s), inertia = V.transpose() * terms.mass * V;
  IndependentTerms all;
  all.mass = inertia.leftCols(s);
  for (Eigen::Index k = 0; k < V.cols(); ++k) {
    MatrixX form = MatrixX::Zero(V.rows(), V.rows());
    for (Eigen::Index a = 0; a < V.rows(); ++a)
      form +=
          V(a, k) * terms.velocity[static_cast<std::size_t>(a)] - inertia(k, a) * forms[static_cast<std::size_t>(a)];
    all.velocity.push_back(moving.transpose() * form * moving);
  }
  all.viscous = V.transpose() * terms.viscous * moving;
  all.static_terms = {V.transpose() * terms.static_terms.weight, V.transpose() * terms.static_terms.springs,
                      V.transpose() * terms.static_terms.loads};
  all.input = V.transpose() * terms.input;
  return all;
}

}  // namespace

Expected<SpeedTerms> EquationTerms::speed_terms(const VectorX& q, const SpeedChoice& choice, double time) {
  const auto d = static_cast<Eigen::Index>(engine_->independent.size());
  const auto s = static_cast<Eigen::Index>(choice.speeds.size()),
             p = static_cast<Eigen::Index>(choice.constrained.size());
  if (s == 0 || s + p != d)
    throw std::invalid_argument("speeds, and what is zero, must be as many as the degrees of freedom, " +
                                std::to_string(d) + "; they are " + std::to_string(s) + " and " + std::to_string(p));
  const Expected<IndependentTerms> terms = independent_terms(q, time);
  Expected<SpeedTerms> found;
  found.outcome = terms.outcome;
  if (!terms) return found;
  std::vector<GeneralisedSpeed> all = choice.speeds;
  all.insert(all.end(), choice.constrained.begin(), choice.constrained.end());
  std::vector<MatrixX> forms;
  found.outcome = engine_->speed_rows(q.data(), all, found.value.rows, forms);
  if (!found) return found;
  if (!is_regular(found.value.rows, engine_->mechanism, engine_->independent)) {
    found.outcome = {MotionStatus::drive_singularity,
                     time,
                     p == 0 ? "the speeds do not determine the mechanism's motion there"
                            : "the speeds, with what is zero, do not determine the mechanism's motion there",
                     {}};
    return found;
  }
  const MatrixX V = found.value.rows.partialPivLu().inverse();
  const IndependentTerms whole = project_on_speeds(terms.value, V, forms, s);
  if (!is_finite(whole)) {
    found.outcome = make_overflow_outcome(time, "the equation of motion", engine_->mechanism);
    return found;
  }
  found.value.rates = V.leftCols(s);
  found.value.speed_equations = select_rows(whole, 0, s);
  found.value.constraint_equations = select_rows(whole, s, p);
  return found;
}

}  // namespace balance
