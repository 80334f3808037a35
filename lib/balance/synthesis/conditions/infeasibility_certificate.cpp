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

namespace balance::conditions {

namespace {

/// Scaled residuals below this cannot be distinguished from zero.
constexpr double certificate_residual_threshold = 1e-8;

/// Conditions in natural units, with a largest entry of one in each row: entry = row_unit · R · parameter unit.
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
  // A condition without entries proves nothing.
  out.row_unit = (out.row_unit.array() > 0).select(out.row_unit.cwiseInverse(), 0.0);
  out.rows = out.row_unit.asDiagonal() * out.rows;
  return out;
}

/// The problem in which proofs are sought. All known terms are merged into one column, whose factor is a positive
/// constant; those that free numbers change stay separate and must not occur.
struct CertificateProblem {
  std::vector<dynamics::Parameter> parameters;
  MatrixX rows;
};

CertificateProblem merge_known_terms(const Conditions& conditions, const NaturalConditions& natural, double mass) {
  const Eigen::Index parameter_count = conditions.parameter_columns(),
                     known_count = conditions.known_term_values.size();
  CertificateProblem problem;
  problem.parameters.assign(conditions.parameters.begin(), conditions.parameters.begin() + parameter_count);
  problem.rows = natural.rows.leftCols(parameter_count);
  if (known_count == 0) return problem;
  VectorX merged = VectorX::Zero(natural.rows.rows());
  const auto add = [&](const VectorX& column, const dynamics::Parameter& parameter) {
    problem.rows.conservativeResize(Eigen::NoChange, problem.rows.cols() + 1);
    problem.rows.rightCols(1) = column;
    problem.parameters.push_back(parameter);
  };
  for (Eigen::Index k = 0; k < known_count; ++k) {
    const VectorX column = natural.rows.col(parameter_count + k);
    if (conditions.is_variable_term(k))
      add(column,
          {"", "", "", dynamics::ParameterOwner::load, static_cast<int>(k), 0, dynamics::ParameterKind::force, 0});
    else
      merged += column * (conditions.known_term_values[k] / natural.parameter_unit[parameter_count + k] / mass);
  }
  add(merged, {"", "", "", dynamics::ParameterOwner::load, -1, 0, dynamics::ParameterKind::known_term, 0});
  return problem;
}

/// Expands a certificate to the columns of all terms.
FarkasCertificate expand_certificate(FarkasCertificate certificate, const Conditions& conditions,
                                     const NaturalConditions& natural) {
  const Eigen::Index parameter_count = conditions.parameter_columns(),
                     known_count = conditions.known_term_values.size();
  VectorX coefficients(parameter_count + known_count);
  coefficients.head(parameter_count) = certificate.coefficients.head(parameter_count);
  const VectorX known_coefficients = natural.rows.rightCols(known_count).transpose() * certificate.combination;
  for (Eigen::Index k = 0; k < known_count; ++k)
    coefficients[parameter_count + k] =
        conditions.known_term_values[k] == 0 || conditions.is_variable_term(k) ? 0 : known_coefficients[k];
  for (Eigen::Index k = parameter_count; k < coefficients.size(); ++k)
    if (std::abs(coefficients[k]) < certificate_coefficient_tolerance) coefficients[k] = 0;
  certificate.coefficients = coefficients;
  return certificate;
}

/// The proof in SI units, scaled such that the first coefficient is ±1.
InfeasibilityCertificate to_si_certificate(InfeasibilityCertificate::Kind kind, const FarkasCertificate& certificate,
                                           const NaturalConditions& natural) {
  InfeasibilityCertificate proof{kind, natural.row_unit.cwiseProduct(certificate.combination),
                                 certificate.coefficients.cwiseQuotient(natural.parameter_unit), ""};
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
  const Eigen::Index parameter_count = conditions.parameter_columns();
  for (Eigen::Index k = 0; k < conditions.known_term_values.size(); ++k)
    if (coefficients[parameter_count + k] != 0)
      text += fmt::format("{}{} = {:.6g}", text.empty() ? "with " : " and ",
                          conditions.parameters[static_cast<std::size_t>(parameter_count + k)].name,
                          conditions.known_term_values[k]);
  return text;
}

/// "it is positive", "both are positive", "none can be negative and link1.J is positive".
std::string sign_reason(const Conditions& conditions, const VectorX& coefficients) {
  std::vector<std::string> positive;
  Eigen::Index terms = 0;
  if (const std::string known_term_text = known_text(conditions, coefficients); !known_term_text.empty())
    return known_term_text + " the left-hand side is positive";
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

/// tr(Q P) for a flat body's pseudo-inertia P (rank 3) can vanish only if Q has rank one.
bool is_valid_for_flat_bodies(const PseudoInertiaCone& cone, const VectorX& coefficients) {
  return std::any_of(cone.blocks.begin(), cone.blocks.end(), [&](const PseudoInertiaBlock& block) {
    if (!block.is_body) return false;
    const MatrixX matrix = block.matrix(coefficients);
    if (matrix.norm() < certificate_coefficient_tolerance) return false;
    if (block.size != 4) return true;
    const numerics::SymmetricEigenSolver solver(matrix, Eigen::EigenvaluesOnly);
    return solver.eigenvalues()[2] > 1e-6 * solver.eigenvalues()[3];
  });
}

/// The given parameters are physical; a proof that they contradict, even if only by making it vanish, is invalid.
bool is_consistent_with(const InfeasibilityCertificate& proof, const VectorX& parameters) {
  const VectorX terms = proof.coefficients.cwiseProduct(parameters);
  return terms.sum() > certificate_coefficient_tolerance * terms.cwiseAbs().sum();
}

VectorX current_parameters(const Conditions& conditions, const Mechanism& mechanism) {
  dynamics::FreeSprings loose(mechanism.springs.size(), false);
  for (const dynamics::Parameter& p : conditions.parameters)
    if (p.kind == dynamics::ParameterKind::stiffness_moment) loose.at(static_cast<std::size_t>(p.index)) = true;
  VectorX values = term_values(mechanism, loose);
  if (values.size() != static_cast<Eigen::Index>(conditions.parameters.size()))
    throw std::invalid_argument("the conditions are not those of this mechanism");
  return values;
}

}  // namespace

std::optional<InfeasibilityCertificate> certify_infeasible(const Conditions& conditions, const Mechanism& mechanism) {
  if (conditions.status != ConditionsStatus::done || conditions.matrix.rows() == 0) return std::nullopt;
  const VectorX current_values = current_parameters(conditions, mechanism);
  const NaturalConditions natural = to_natural_units(conditions, mechanism);
  const CertificateProblem problem = merge_known_terms(conditions, natural, total_mass(mechanism));
  if (const auto certificate = find_sign_certificate(problem.rows, problem.parameters)) {
    InfeasibilityCertificate proof = to_si_certificate(InfeasibilityCertificate::Kind::sign,
                                                       expand_certificate(*certificate, conditions, natural), natural);
    proof.statement =
        fmt::format("{}: {}", combination_text(conditions, proof), sign_reason(conditions, proof.coefficients));
    if (is_consistent_with(proof, current_values)) return proof;
  }
  const PseudoInertiaCone cone(problem.parameters);
  if (const auto certificate = find_cone_certificate(problem.rows, cone)) {
    InfeasibilityCertificate proof = to_si_certificate(InfeasibilityCertificate::Kind::cone,
                                                       expand_certificate(*certificate, conditions, natural), natural);
    const std::string known_term_text = known_text(conditions, proof.coefficients);
    proof.statement =
        fmt::format("{}: {}the left-hand side is positive for every distribution of mass{}",
                    combination_text(conditions, proof), known_term_text.empty() ? "" : known_term_text + " ",
                    is_valid_for_flat_bodies(cone, certificate->coefficients) ? "" : " that is not flat");
    if (is_consistent_with(proof, current_values)) return proof;
  }
  return std::nullopt;
}

namespace {

/// The minimum of c · (constant + gradient z) in the box, in ordinary arithmetic, minus an upper bound on round-off.
/// @param size of the terms summed in each c
double rigorous_minimum(const VectorX& c, const VectorX& size, const BoundedParameters& parameters) {
  double minimum = c.dot(parameters.constant), error_bound = size.dot(parameters.constant.cwiseAbs());
  for (Eigen::Index j = 0; j < parameters.gradient.cols(); ++j) {
    const double rate = c.dot(parameters.gradient.col(j)), terms = size.dot(parameters.gradient.col(j).cwiseAbs());
    const double lower = parameters.lower[j], upper = parameters.upper[j];
    if (std::abs(rate) <= 1e-12 * terms && (std::isinf(lower) || std::isinf(upper))) continue;
    minimum += std::min(rate * lower, rate * upper);
    error_bound += terms * std::max(std::abs(lower), std::abs(upper));
  }
  return minimum - 1e-11 * error_bound;
}

}  // namespace

namespace {

/// The proof by this combination of the scaled conditions; std::nullopt if it proves nothing.
std::optional<InfeasibilityCertificate> verify_bounds_certificate(const VectorX& lambda, const Conditions& conditions,
                                                                  const BoundedParameters& parameters) {
  InfeasibilityCertificate proof{InfeasibilityCertificate::Kind::bounds, lambda.cwiseQuotient(conditions.row_scales),
                                 VectorX(), ""};
  proof.coefficients = conditions.matrix.transpose() * proof.combination;
  const double scale = 1 / numerics::max_abs(proof.coefficients);
  proof.combination *= scale;
  proof.coefficients *= scale;
  const VectorX size = conditions.matrix.cwiseAbs().transpose() * proof.combination.cwiseAbs();
  proof.coefficients = (proof.coefficients.array().abs() > 1e-12 * size.array()).select(proof.coefficients, 0.0);
  const double lower_bound = rigorous_minimum(proof.coefficients, size, parameters);
  // In scaled residuals: everywhere, some condition is violated by at least this much.
  if (!(lower_bound >
        certificate_residual_threshold * proof.combination.cwiseProduct(conditions.row_scales).lpNorm<1>()))
    return std::nullopt;
  proof.statement = fmt::format("{} within the bounds: the left-hand side is at least {:.3g}",
                                combination_text(conditions, proof), lower_bound);
  proof.minimum = lower_bound;
  return proof;
}

/// Multipliers of this size, relative to the largest, are usually errors of the linear program.
constexpr double multiplier_tolerance = 1e-7;

}  // namespace

std::optional<InfeasibilityCertificate> certify_infeasible(const Conditions& conditions,
                                                           const BoundedParameters& parameters) {
  if (conditions.status != ConditionsStatus::done || conditions.matrix.rows() == 0) return std::nullopt;
  const MatrixX rows = conditions.row_scales.cwiseInverse().asDiagonal() * conditions.matrix;
  const std::optional<VectorX> lambda = find_bounds_certificate(rows * parameters.constant, rows * parameters.gradient,
                                                                parameters.lower, parameters.upper);
  if (!lambda || lambda->lpNorm<1>() > 1 / certificate_residual_threshold) return std::nullopt;
  const VectorX without_errors =
      (lambda->array().abs() > multiplier_tolerance * numerics::max_abs(*lambda)).select(*lambda, 0.0);
  if (auto proof = verify_bounds_certificate(without_errors, conditions, parameters)) return proof;
  return verify_bounds_certificate(*lambda, conditions, parameters);
}

}  // namespace balance::conditions
