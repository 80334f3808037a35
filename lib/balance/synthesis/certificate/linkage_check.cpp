#include "balance/synthesis/certificate/linkage_check.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <Eigen/SVD>

#include <cmath>
#include <random>

namespace balance::certificate {
namespace {

/// Relative: both are solved to about 1e-10.
constexpr double agreement_tolerance = 1e-9;
/// Relative to the largest entry of the conditions.
constexpr double entry_round_off = 1e-14;
/// Of the conditions' rows with length 1: the library's accuracy, with a margin.
constexpr double rank_tolerance = 1e-8, row_tolerance = 1e-7;
constexpr int compared_lengths = 3;
constexpr int max_trials = 60;

std::vector<Goal> force_goals(const DesignSpace& space) {
  for (const Goal& goal : space.start.design.goals)
    if (goal.kind == GoalKind::force || goal.kind == GoalKind::dynamic) return {Goal{GoalKind::force}};
  return {Goal{GoalKind::statics}};
}

/// @param turn of its body, PlanarLinkage::turns
/// @param place first corner
Vector3 corner_place(const FreeCounterweight& counterweight, std::size_t corner, const VectorX& x,
                     LengthPolynomial::Coefficient turn, Vector3 place) {
  // corners are measured from the tree joint; differences are the same from the body's origin
  const auto shift = (counterweight.corners[corner].evaluate(x) - counterweight.corners[0].evaluate(x)) / turn;
  place[0] += shift.real();
  place[1] += shift.imag();
  return place;
}

/// The conditions of the library at given lengths, for masses at the corners of the counterweights' places.
struct CornerConditions {
  MatrixX matrix;                   ///< conditions × corners
  VectorX right;                    ///< matrix · masses = right
  std::vector<std::size_t> owners;  ///< per corner: its counterweight
};

void load(const FreeCounterweight& counterweight, std::size_t corner, const VectorX& x,
          LengthPolynomial::Coefficient turn, Mechanism& mechanism) {
  if (counterweight.disc >= 0) {
    Disc& disc = mechanism.discs[static_cast<std::size_t>(counterweight.disc)];
    disc.mass = 1;
    disc.position = corner_place(counterweight, corner, x, turn, disc.position);
  } else {
    Attachment& attachment = mechanism.attachments[static_cast<std::size_t>(counterweight.attachment)];
    attachment.mass = 1;
    attachment.position = corner_place(counterweight, corner, x, turn, attachment.position);
  }
}

/// Removes what is round-off beside the largest entry: rows of nothing else would be made as large as the others.
void remove_round_off(MatrixX& entries) {
  const double negligible = entry_round_off * numerics::max_abs(entries);
  entries = (entries.array().abs() <= negligible).select(0.0, entries);
}

/// @return none if the mechanism cannot be assembled or its conditions are not clear
std::optional<CornerConditions> derive_corner_conditions(const DesignSpace& space, const PlanarLinkage& linkage,
                                                         const VectorX& x) {
  VectorX numbers = x;
  for (const FreeCounterweight& counterweight : linkage.counterweights) {
    if (counterweight.mass_number >= 0) numbers[counterweight.mass_number] = 0;
    for (const int number : counterweight.place_numbers)
      if (number >= 0) numbers[number] = space.start.free_numbers[static_cast<std::size_t>(number)].lower;
  }
  const study::DesignInstance instance = space.instantiate(numbers);
  if (!instance.mode_issue.empty()) return {};
  Mechanism mechanism = instance.mechanism;
  for (const FreeCounterweight& counterweight : linkage.counterweights) {
    if (counterweight.disc >= 0)
      mechanism.discs[static_cast<std::size_t>(counterweight.disc)].mass = 0;
    else
      mechanism.attachments[static_cast<std::size_t>(counterweight.attachment)].mass = 0;
  }
  const Conditions conditions = derive_conditions(mechanism, force_goals(space));
  if (conditions.status != ConditionsStatus::done || conditions.known_term_values.size() > 0) return {};
  const VectorX base = conditions::term_values(mechanism);
  CornerConditions result;
  std::vector<VectorX> columns;
  for (std::size_t i = 0; i < linkage.counterweights.size(); ++i) {
    const FreeCounterweight& counterweight = linkage.counterweights[i];
    const auto turn = linkage.turns[static_cast<std::size_t>(counterweight.body)];
    for (std::size_t corner = 0; corner < counterweight.corners.size(); ++corner) {
      Mechanism loaded = mechanism;
      load(counterweight, corner, x, turn, loaded);
      columns.push_back(conditions.matrix * (conditions::term_values(loaded) - base));
      result.owners.push_back(i);
    }
  }
  result.right = -(conditions.matrix * base);
  result.matrix.resize(conditions.matrix.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) result.matrix.col(static_cast<Eigen::Index>(c)) = columns[c];
  remove_round_off(result.matrix);
  return result;
}

std::optional<double> find_min_mass(const CornerConditions& conditions, const PlanarLinkage& linkage,
                                    const VectorX& x) {
  const Eigen::Index corners = conditions.matrix.cols();
  numerics::LinearProgram program(corners);
  program.lower.setZero();
  program.cost.setOnes();
  for (Eigen::Index r = 0; r < conditions.matrix.rows(); ++r) {
    const VectorX row = conditions.matrix.row(r).transpose();
    const double scale = std::max(numerics::max_abs(row), std::abs(conditions.right[r]));
    if (scale == 0) continue;
    program.add_row(conditions.right[r] / scale, row / scale, conditions.right[r] / scale);
  }
  for (std::size_t i = 0; i < linkage.counterweights.size(); ++i) {
    VectorX row(corners);
    for (Eigen::Index c = 0; c < corners; ++c) row[c] = conditions.owners[static_cast<std::size_t>(c)] == i ? 1 : 0;
    program.add_row(linkage.counterweights[i].lower, row, linkage.counterweights[i].upper);
  }
  const numerics::LinearProgramSolution solution = solve_linear_program(program);
  if (solution.status == numerics::LinearProgramStatus::infeasible) return std::numeric_limits<double>::infinity();
  if (solution.status != numerics::LinearProgramStatus::optimal) return {};
  return solution.x.sum() + linkage.fixed_size.evaluate(x).real();
}

/// Orthonormal basis of the rows, which are made comparable first.
MatrixX row_basis(MatrixX rows) {
  remove_round_off(rows);
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    const double size = rows.row(r).norm();
    if (size > 0) rows.row(r) /= size;
  }
  const numerics::SingularValueDecomposition svd(rows, Eigen::ComputeThinV);
  const VectorX& values = svd.singularValues();
  Eigen::Index rank = 0;
  while (rank < values.size() && values[rank] > rank_tolerance * values[0]) ++rank;
  return svd.matrixV().leftCols(rank).transpose();
}

/// Whether the virtual heights of corners and fixed masses, per unknown, are combinations of the library's conditions
/// and conversely.
bool has_same_rows(const CornerConditions& conditions, const VirtualLinkage& dual, const VectorX& x) {
  const Eigen::Index corners = conditions.matrix.cols();
  MatrixX own(dual.unknowns, corners + 1), derived(conditions.matrix.rows(), corners + 1);
  const auto set_column = [&](Eigen::Index column, const VirtualHeight& height) {
    for (Eigen::Index j = 0; j < dual.unknowns; ++j)
      own(j, column) =
          height.coefficients[static_cast<std::size_t>(j)].evaluate(x).real() / height.scale.evaluate(x).real();
  };
  Eigen::Index column = 0;
  for (const auto& counterweight : dual.corners)
    for (const VirtualHeight& corner : counterweight) set_column(column++, corner);
  set_column(corners, dual.fixed_masses);
  derived << conditions.matrix, -conditions.right;
  const MatrixX a = row_basis(own), b = row_basis(derived);
  if (a.rows() != b.rows()) return false;
  return a.rows() == 0 || (a - (a * b.transpose()) * b).norm() <= row_tolerance;
}

}  // namespace

std::optional<double> compute_min_mass(const DesignSpace& space, const PlanarLinkage& linkage, const VectorX& x) {
  const std::optional<CornerConditions> conditions = derive_corner_conditions(space, linkage, x);
  return conditions ? find_min_mass(*conditions, linkage, x) : std::nullopt;
}

std::string find_disagreement(const DesignSpace& space, const PlanarLinkage& linkage, const VirtualLinkage& dual,
                              const BoxProgram& program, const LengthBox& box) {
  double most = 0;
  for (const FreeCounterweight& counterweight : linkage.counterweights) most += counterweight.upper;
  std::mt19937_64 random(1);
  std::vector<MassLimits> limits = list_mass_limits(linkage);
  int compared = 0;
  for (int trial = 0; trial < max_trials && compared < compared_lengths; ++trial) {
    VectorX x = space.start_values();
    for (const int length : program.lengths()) {
      const double part = static_cast<double>(random() >> 11) * 0x1p-53;
      // the last trials stay near the start, which is more likely to be assembled
      const double near = trial < max_trials / 2 ? 1 : 0.1;
      x[length] += near * (box.lower[length] + part * (box.upper[length] - box.lower[length]) - x[length]);
    }
    std::optional<CornerConditions> conditions;
    std::optional<double> own;
    try {
      conditions = derive_corner_conditions(space, linkage, x);
      if (conditions) own = find_min_mass(*conditions, linkage, x);
    } catch (const SpecError&) {
    }
    if (!own) continue;
    ++compared;
    const double bound = program.bound({x, x}, {}, limits).bound;
    const double fixed = linkage.fixed_size.evaluate(x).real();
    const bool agrees =
        std::isinf(*own) ? bound > fixed + most : std::abs(bound - *own) <= agreement_tolerance * (1 + std::abs(*own));
    if (!agrees || !has_same_rows(*conditions, dual, x))
      return "its conditions at random lengths are not those of its closures";
  }
  return compared == compared_lengths ? std::string()
                                      : "it could not be assembled with other lengths, for a comparison";
}

}  // namespace balance::certificate
