#include "balance/synthesis/certificate/linkage_check.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <cmath>
#include <random>

namespace balance::certificate {
namespace {

/// Relative: both are solved to about 1e-10.
constexpr double agreement_tolerance = 1e-9;
constexpr int compared_lengths = 3;
constexpr int max_trials = 60;

std::vector<Goal> force_goals(const DesignSpace& space) {
  for (const Goal& goal : space.start.design.goals)
    if (goal.kind == GoalKind::force || goal.kind == GoalKind::dynamic) return {Goal{GoalKind::force}};
  return {Goal{GoalKind::statics}};
}

/// @param mechanism its counterweights are at their first corners
Vector3 corner_place(const FreeCounterweight& counterweight, std::size_t corner, const VectorX& x,
                     const Mechanism& mechanism) {
  Vector3 place = mechanism.attachments[static_cast<std::size_t>(counterweight.attachment)].position;
  // corners are measured from the tree joint; differences are the same from the body's origin
  const auto shift = counterweight.corners[corner].evaluate(x) - counterweight.corners[0].evaluate(x);
  place[0] += shift.real();
  place[1] += shift.imag();
  return place;
}

}  // namespace

std::optional<double> compute_min_mass(const DesignSpace& space, const PlanarLinkage& linkage, const VectorX& x) {
  VectorX numbers = x;
  for (const FreeCounterweight& counterweight : linkage.counterweights) {
    if (counterweight.mass_number >= 0) numbers[counterweight.mass_number] = 0;
    for (const int number : counterweight.place_numbers)
      if (number >= 0) numbers[number] = space.start.free_numbers[static_cast<std::size_t>(number)].lower;
  }
  const DesignInstance instance = space.instantiate(numbers);
  if (!instance.mode_issue.empty()) return {};
  Mechanism mechanism = instance.mechanism;
  for (const FreeCounterweight& counterweight : linkage.counterweights)
    mechanism.attachments[static_cast<std::size_t>(counterweight.attachment)].mass = 0;
  const Conditions conditions = derive_conditions(mechanism, force_goals(space));
  if (conditions.status != ConditionsStatus::done || conditions.known_term_values.size() > 0) return {};
  const VectorX base = term_values(mechanism);
  std::vector<VectorX> columns;
  std::vector<std::size_t> owners;
  for (std::size_t i = 0; i < linkage.counterweights.size(); ++i) {
    const FreeCounterweight& counterweight = linkage.counterweights[i];
    for (std::size_t corner = 0; corner < counterweight.corners.size(); ++corner) {
      Mechanism loaded = mechanism;
      Attachment& attachment = loaded.attachments[static_cast<std::size_t>(counterweight.attachment)];
      attachment.mass = 1;
      attachment.position = corner_place(counterweight, corner, x, mechanism);
      columns.push_back(conditions.matrix * (term_values(loaded) - base));
      owners.push_back(i);
    }
  }
  LinearProgram program(static_cast<Eigen::Index>(columns.size()));
  program.lower.setZero();
  program.cost.setOnes();
  const VectorX right = -(conditions.matrix * base);
  for (Eigen::Index r = 0; r < conditions.matrix.rows(); ++r) {
    VectorX row(static_cast<Eigen::Index>(columns.size()));
    for (std::size_t c = 0; c < columns.size(); ++c) row[static_cast<Eigen::Index>(c)] = columns[c][r];
    const double scale = std::max(max_abs(row), std::abs(right[r]));
    if (scale == 0) continue;
    program.add_row(right[r] / scale, row / scale, right[r] / scale);
  }
  for (std::size_t i = 0; i < linkage.counterweights.size(); ++i) {
    VectorX row(static_cast<Eigen::Index>(columns.size()));
    for (std::size_t c = 0; c < columns.size(); ++c) row[static_cast<Eigen::Index>(c)] = owners[c] == i ? 1 : 0;
    program.add_row(linkage.counterweights[i].lower, row, linkage.counterweights[i].upper);
  }
  const LinearProgramSolution solution = solve_linear_program(program);
  if (solution.status == LinearProgramStatus::infeasible) return std::numeric_limits<double>::infinity();
  if (solution.status != LinearProgramStatus::optimal) return {};
  return solution.x.sum() + linkage.fixed_size.evaluate(x).real();
}

std::string find_disagreement(const DesignSpace& space, const PlanarLinkage& linkage, const BoxProgram& program,
                              const LengthBox& box) {
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
    std::optional<double> own;
    try {
      own = compute_min_mass(space, linkage, x);
    } catch (const SpecError&) {
    }
    if (!own) continue;
    ++compared;
    const double bound = program.bound({x, x}, {}, limits).bound;
    const double fixed = linkage.fixed_size.evaluate(x).real();
    const bool agrees =
        std::isinf(*own) ? bound > fixed + most : std::abs(bound - *own) <= agreement_tolerance * (1 + std::abs(*own));
    if (!agrees) return "its conditions at random lengths are not those of its closures";
  }
  return compared == compared_lengths ? std::string()
                                      : "it could not be assembled with other lengths, for a comparison";
}

}  // namespace balance::certificate
