#include "balance/study/design_study.hpp"

#include "balance/conditions/modular.hpp"
#include "balance/conditions/proportion.hpp"
#include "balance/study/objective.hpp"
#include "balance/study/simulate.hpp"
#include "balance/study/start_pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance {

namespace {

/// What a designer adds to a mechanism that balances it: not there before.
bool is_added(const std::string& path) {
  const auto ends = [&](const char* end) { return path.ends_with(end); };
  const bool carried = path.starts_with("counterweights.") || path.starts_with("discs.");
  return (carried && (ends(".mass") || path.find(".inertia") != std::string::npos)) ||
         (path.starts_with("springs.") && ends(".stiffness"));
}

VectorX values_before(const std::vector<FreeNumber>& numbers) {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const FreeNumber& number = numbers[i];
    const bool absent = !number.start_given && is_added(number.path) && number.lower <= 0 && number.upper >= 0;
    x[static_cast<Eigen::Index>(i)] = absent ? 0 : number.start;
  }
  return x;
}

DesignProblem state_problem(const DesignSpace& space, const DesignStudyOptions& options, const VectorX& before) {
  DesignProblem problem;
  const auto& numbers = space.start.free_numbers;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    problem.variables.push_back(
        {numbers[i].path, numbers[i].lower, numbers[i].upper, before[static_cast<Eigen::Index>(i)]});
  problem.mechanism_at = [&space, start = start_coordinates(space.start)](const VectorX& x) {
    return assembled_at(space.at(x).mechanism, start);
  };
  problem.goals = options.goals.empty() ? space.start.design.goals : options.goals;
  if (problem.variables.empty()) throw std::invalid_argument("a design needs free numbers, and the spec has none");
  if (problem.goals.empty()) throw std::invalid_argument("a design needs a goal");
  if (!space.start.trajectories.empty()) problem.options.about = space.start.trajectories.front().about;
  problem.derive = options.modular ? derive_modular_conditions : derive_conditions;
  problem.modular = options.modular;
  problem.search = options.search;
  problem.options.loose_springs = find_loose_springs(problem);
  const auto& terms = options.minimize.empty() ? space.start.design.minimize : options.minimize;
  if (!terms.empty()) problem.objective = build_objective(space, terms, before, problem.options.loose_springs);
  return problem;
}

Result run(const Study& study, const std::string& name) {
  for (const Trajectory& trajectory : study.trajectories) {
    if (trajectory.name != name) continue;
    try {
      return simulate(study.mechanism, trajectory);
    } catch (const std::invalid_argument& error) {
      Result result;
      result.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
      return result;
    }
  }
  return {};
}

void weigh(const Mechanism& mechanism, double& mass, double& inertia) {
  const std::vector<Parameter> parameters = list_parameters(mechanism);
  const VectorX values = parameter_values(mechanism);
  mass = mass_coefficients(parameters).dot(values);
  inertia = inertia_coefficients(parameters).dot(values);
}

/// "the centre of mass moves at 0.5 times the tool's displacement"
std::string proportion_note(const Mechanism& mechanism) {
  const MatrixX A = com_per_tool(mechanism);
  if (A.size() == 0) return "";
  const double factor = A.trace() / static_cast<double>(A.rows());
  if ((A - factor * MatrixX::Identity(A.rows(), A.cols())).norm() < 1e-9 * (1 + A.norm()))
    return fmt::format("the centre of mass moves by {:.6g} times the tool's displacement", factor);
  std::string rows;
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    rows += i == 0 ? "[" : "; ";
    for (Eigen::Index j = 0; j < A.cols(); ++j) rows += fmt::format("{}{:.6g}", j == 0 ? "" : ", ", A(i, j));
  }
  return "the centre of mass moves by " + rows + "] times the tool's displacement";
}

}  // namespace

DesignReport design_study(const DesignSpace& space, const DesignStudyOptions& options) {
  DesignReport report;
  report.numbers = space.start.free_numbers;
  report.before = values_before(report.numbers);
  const DesignProblem problem = state_problem(space, options, report.before);
  report.outcome = solve(problem);
  if (report.outcome.status == DesignStatus::unsolved) return report;

  report.study_before = space.at(report.before);
  report.study_after = space.at(report.outcome.x);
  weigh(report.study_before.mechanism, report.mass_before, report.inertia_before);
  weigh(report.study_after.mechanism, report.mass_after, report.inertia_after);
  const auto proportional = [](const Goal& goal) { return goal.kind == GoalKind::proportional; };
  if (report.outcome.status == DesignStatus::balanced &&
      std::any_of(problem.goals.begin(), problem.goals.end(), proportional))
    report.notes.push_back(proportion_note(report.study_after.mechanism));
  if (!options.trajectories) return report;
  for (const Trajectory& trajectory : report.study_after.trajectories)
    report.comparisons.push_back(
        {trajectory.name, run(report.study_before, trajectory.name), run(report.study_after, trajectory.name)});
  return report;
}

}  // namespace balance
