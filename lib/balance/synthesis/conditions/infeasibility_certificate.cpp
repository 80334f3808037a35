#include "balance/synthesis/conditions/infeasibility_certificate.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/conditions/farkas_certificates.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

/// Scaled residuals below this are not told from zero.
constexpr double certificate_residual_threshold = 1e-8;

/// Conditions in natural units, each row's largest entry one: entry = row_unit · R · parameter unit.
struct NaturalConditions {
  MatrixX rows;
  VectorX row_unit;
  VectorX parameter_unit;
};

NaturalConditions to_natural_units(const Conditions& conditions, const Mechanism& mechanism) {
  NaturalConditions out;
  out.parameter_unit = NaturalUnits(mechanism, conditions.parameters).parameter;
  out.rows = conditions.matrix * out.parameter_unit.asDiagonal();
  for (std::size_t p = 0; p < conditions.parameters.size(); ++p)
    if (is_always_zero(conditions.parameters[p])) out.rows.col(static_cast<Eigen::Index>(p)).setZero();
  out.row_unit = out.rows.rowwise().lpNorm<Eigen::Infinity>();
  // A condition that asks nothing proves nothing.
  out.row_unit = (out.row_unit.array() > 0).select(out.row_unit.cwiseInverse(), 0.0);
  out.rows = out.row_unit.asDiagonal() * out.rows;
  return out;
}

/// The problem that proofs are looked for in: all known terms in one column that is positive, since it is what it is; those that
/// free numbers change stay for themselves and must not occur.
struct CertificateProblem {
  std::vector<Parameter> parameters;
  MatrixX rows;
};

CertificateProblem merge_known_terms(const Conditions& conditions, const NaturalConditions& natural, double mass) {
  const Eigen::Index own = conditions.parameter_columns(), known = conditions.known_term_values.size();
  CertificateProblem problem;
  problem.parameters.assign(conditions.parameters.begin(), conditions.parameters.begin() + own);
  problem.rows = natural.rows.leftCols(own);
  if (known == 0) return problem;
  VectorX together = VectorX::Zero(natural.rows.rows());
  const auto add = [&](const VectorX& column, const Parameter& parameter) {
    problem.rows.conservativeResize(Eigen::NoChange, problem.rows.cols() + 1);
    problem.rows.rightCols(1) = column;
    problem.parameters.push_back(parameter);
  };
  for (Eigen::Index k = 0; k < known; ++k) {
    const VectorX column = natural.rows.col(own + k);
    if (conditions.is_variable_term(k))
      add(column, {"", "", "", ParameterOwner::load, static_cast<int>(k), 0, ParameterKind::force, 0});
    else
      together += column * (conditions.known_term_values[k] / natural.parameter_unit[own + k] / mass);
  }
  add(together, {"", "", "", ParameterOwner::load, -1, 0, ParameterKind::known_term, 0});
  return problem;
}

/// A certificate in the columns of all terms.
FarkasCertificate expand_certificate(FarkasCertificate found, const Conditions& conditions,
                                     const NaturalConditions& natural) {
  const Eigen::Index own = conditions.parameter_columns(), known = conditions.known_term_values.size();
  VectorX all(own + known);
  all.head(own) = found.coefficients.head(own);
  const VectorX exact = natural.rows.rightCols(known).transpose() * found.combination;
  for (Eigen::Index k = 0; k < known; ++k)
    all[own + k] = conditions.known_term_values[k] == 0 || conditions.is_variable_term(k) ? 0 : exact[k];
  for (Eigen::Index k = own; k < all.size(); ++k)
    if (std::abs(all[k]) < certificate_coefficient_tolerance) all[k] = 0;
  found.coefficients = all;
  return found;
}

/// The proof in SI, its first coefficient of size one.
InfeasibilityCertificate to_si_certificate(InfeasibilityCertificate::Kind kind, const FarkasCertificate& found,
                                           const NaturalConditions& natural) {
  InfeasibilityCertificate proof{kind, natural.row_unit.cwiseProduct(found.combination),
                                 found.coefficients.cwiseQuotient(natural.parameter_unit), ""};
  const auto first =
      std::find_if(proof.coefficients.begin(), proof.coefficients.end(), [](double c) { return c != 0; });
  const double scale = 1 / std::abs(*first);
  proof.combination *= scale;
  proof.coefficients *= scale;
  return proof;
}

std::string combination_text(const Conditions& conditions, const InfeasibilityCertificate& proof) {
  return linear_combination_text(conditions.parameters, proof.coefficients) + " = 0 cannot hold";
}

/// "with push.fy = -5" for the known terms of a proof; empty if it has none.
std::string known_text(const Conditions& conditions, const VectorX& coefficients) {
  std::string text;
  const Eigen::Index own = conditions.parameter_columns();
  for (Eigen::Index k = 0; k < conditions.known_term_values.size(); ++k)
    if (coefficients[own + k] != 0)
      text +=
          fmt::format("{}{} = {:.6g}", text.empty() ? "with " : " and ",
                      conditions.parameters[static_cast<std::size_t>(own + k)].name, conditions.known_term_values[k]);
  return text;
}

/// "it is positive", "both are positive", "none can be negative and link1.J is positive".
std::string sign_reason(const Conditions& conditions, const VectorX& coefficients) {
  std::vector<std::string> positive;
  Eigen::Index terms = 0;
  if (const std::string known = known_text(conditions, coefficients); !known.empty())
    return known + " the left-hand side is positive";
  for (std::size_t p = 0; p < conditions.parameters.size(); ++p) {
    if (coefficients[static_cast<Eigen::Index>(p)] == 0) continue;
    ++terms;
    if (parameter_sign(conditions.parameters[p]) == ParameterSign::positive)
      positive.push_back(conditions.parameters[p].name);
  }
  if (static_cast<Eigen::Index>(positive.size()) == terms)
    return terms == 1 ? "it is positive" : terms == 2 ? "both are positive" : "all are positive";
  std::string names = positive[0];
  for (std::size_t i = 1; i < positive.size(); ++i) names += (i + 1 == positive.size() ? " and " : ", ") + positive[i];
  return fmt::format("none can be negative and {} {} positive", names, positive.size() == 1 ? "is" : "are");
}

/// tr(Q P) of a flat body's pseudo-inertia P (rank 3) can only vanish if Q has rank one.
bool is_valid_for_flat_bodies(const PseudoInertiaCone& cone, const VectorX& coefficients) {
  return std::any_of(cone.blocks.begin(), cone.blocks.end(), [&](const PseudoInertiaBlock& block) {
    if (!block.is_body) return false;
    const MatrixX matrix = block.matrix(coefficients);
    if (matrix.norm() < certificate_coefficient_tolerance) return false;
    if (block.size != 4) return true;
    const SymmetricEigenSolver solver(matrix, Eigen::EigenvaluesOnly);
    return solver.eigenvalues()[2] > 1e-6 * solver.eigenvalues()[3];
  });
}

/// The parameters at hand are physical; a proof that they contradict, if only by vanishing, is none.
bool is_consistent_with(const InfeasibilityCertificate& proof, const VectorX& present) {
  const VectorX terms = proof.coefficients.cwiseProduct(present);
  return terms.sum() > certificate_coefficient_tolerance * terms.cwiseAbs().sum();
}

VectorX present_parameters(const Conditions& conditions, const Mechanism& mechanism) {
  FreeSprings loose(mechanism.springs.size(), false);
  for (const Parameter& p : conditions.parameters)
    if (p.kind == ParameterKind::stiffness_moment) loose.at(static_cast<std::size_t>(p.index)) = true;
  VectorX values = term_values(mechanism, loose);
  if (values.size() != static_cast<Eigen::Index>(conditions.parameters.size()))
    throw std::invalid_argument("the conditions are not those of this mechanism");
  return values;
}

}  // namespace

std::optional<InfeasibilityCertificate> certify_infeasible(const Conditions& conditions, const Mechanism& mechanism) {
  if (conditions.status != ConditionsStatus::done || conditions.matrix.rows() == 0) return std::nullopt;
  const VectorX present = present_parameters(conditions, mechanism);
  const NaturalConditions natural = to_natural_units(conditions, mechanism);
  const CertificateProblem problem = merge_known_terms(conditions, natural, total_mass(mechanism));
  if (const auto found = find_sign_certificate(problem.rows, problem.parameters)) {
    InfeasibilityCertificate proof = to_si_certificate(InfeasibilityCertificate::Kind::sign,
                                                       expand_certificate(*found, conditions, natural), natural);
    proof.statement =
        fmt::format("{}: {}", combination_text(conditions, proof), sign_reason(conditions, proof.coefficients));
    if (is_consistent_with(proof, present)) return proof;
  }
  const PseudoInertiaCone cone(problem.parameters);
  if (const auto found = find_cone_certificate(problem.rows, cone)) {
    InfeasibilityCertificate proof = to_si_certificate(InfeasibilityCertificate::Kind::cone,
                                                       expand_certificate(*found, conditions, natural), natural);
    const std::string known = known_text(conditions, proof.coefficients);
    proof.statement = fmt::format("{}: {}the left-hand side is positive for every distribution of mass{}",
                                  combination_text(conditions, proof), known.empty() ? "" : known + " ",
                                  is_valid_for_flat_bodies(cone, found->coefficients) ? "" : " that is not flat");
    if (is_consistent_with(proof, present)) return proof;
  }
  return std::nullopt;
}

namespace {

/// The least value of c · (constant + gradient z) in the box, in plain arithmetic, less all that could be round-off.
/// @param size of the terms that each c is the sum of
double rigorous_minimum(const VectorX& c, const VectorX& size, const BoundedParameters& parameters) {
  double least = c.dot(parameters.constant), doubt = size.dot(parameters.constant.cwiseAbs());
  for (Eigen::Index j = 0; j < parameters.gradient.cols(); ++j) {
    const double rate = c.dot(parameters.gradient.col(j)), terms = size.dot(parameters.gradient.col(j).cwiseAbs());
    const double low = parameters.lower[j], high = parameters.upper[j];
    if (std::abs(rate) <= 1e-12 * terms && (std::isinf(low) || std::isinf(high))) continue;
    least += std::min(rate * low, rate * high);
    doubt += terms * std::max(std::abs(low), std::abs(high));
  }
  return least - 1e-11 * doubt;
}

}  // namespace

std::optional<InfeasibilityCertificate> certify_infeasible(const Conditions& conditions,
                                                           const BoundedParameters& parameters) {
  if (conditions.status != ConditionsStatus::done || conditions.matrix.rows() == 0) return std::nullopt;
  const MatrixX rows = conditions.row_scales.cwiseInverse().asDiagonal() * conditions.matrix;
  const std::optional<VectorX> lambda = find_bounds_certificate(rows * parameters.constant, rows * parameters.gradient,
                                                                parameters.lower, parameters.upper);
  if (!lambda || lambda->lpNorm<1>() > 1 / certificate_residual_threshold) return std::nullopt;
  InfeasibilityCertificate proof{InfeasibilityCertificate::Kind::bounds, lambda->cwiseQuotient(conditions.row_scales),
                                 VectorX(), ""};
  proof.coefficients = conditions.matrix.transpose() * proof.combination;
  const double scale = 1 / max_abs(proof.coefficients);
  proof.combination *= scale;
  proof.coefficients *= scale;
  const VectorX size = conditions.matrix.cwiseAbs().transpose() * proof.combination.cwiseAbs();
  proof.coefficients = (proof.coefficients.array().abs() > 1e-12 * size.array()).select(proof.coefficients, 0.0);
  const double least = rigorous_minimum(proof.coefficients, size, parameters);
  // In scaled residuals: some condition is missed by at least this much everywhere.
  if (!(least > certificate_residual_threshold * proof.combination.cwiseProduct(conditions.row_scales).lpNorm<1>()))
    return std::nullopt;
  proof.statement = fmt::format("{} within the bounds: the left-hand side is at least {:.3g}",
                                combination_text(conditions, proof), least);
  return proof;
}

}  // namespace balance
