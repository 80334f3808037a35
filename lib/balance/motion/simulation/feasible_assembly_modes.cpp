#include "balance/motion/simulation/feasible_assembly_modes.hpp"

#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <algorithm>

namespace balance::simulation {

namespace {

constexpr std::uint64_t max_mode_starts = 60;
constexpr int max_mode_columns = 60;  // for larger mechanisms the search takes too long for a message
constexpr std::size_t max_simulated_modes = 16;

bool depends_on_assembly_mode(MotionStatus status) {
  using enum MotionStatus;
  return status == unreachable || status == drive_singularity || status == assembly_jump ||
         status == constraint_singularity || status == actuation_singularity;
}

template <class S>
std::string describe_feasible_modes_in(const Mechanism& mechanism, const Trajectory& trajectory) {
  const kinematics::Tree<S> tree = kinematics::compile_tree<S>(mechanism, prescribed_coordinates(trajectory));
  if (tree.closures.empty() || tree.columns > max_mode_columns) return "";
  const kinematics::PoseEquations<S> start_equations = make_pose_equations(mechanism, tree, trajectory.from);
  kinematics::ConstraintSystem<S> system(tree, start_equations.drive);
  const kinematics::AssemblySolution selected = solve_pose(mechanism, tree, system, start_equations.target);
  // a pose that leaves freedoms open has a continuum of solutions, not modes
  if (!selected.found ||
      start_equations.drive.row_count() < tree.columns - find_generic_position_rank(tree, selected.y))
    return "";
  kinematics::AssemblyModes<S> modes(mechanism, tree, system, start_equations.target, selected.y);
  for (std::uint64_t start = 1; start <= max_mode_starts; ++start) modes.search_from(start);
  const std::size_t others = modes.modes().size() - 1;
  if (others == 0) return "";
  for (std::size_t m = 1; m < std::min(modes.modes().size(), max_simulated_modes); ++m)
    if (find_outcome_in_mode(mechanism, trajectory, modes.modes()[m]).status == MotionStatus::done)
      return "; another assembly mode can make this motion: " +
             format_assembly_line(mechanism, tree, start_equations.drive, modes.modes()[m]);
  return others == 1 ? "; the other assembly mode cannot make this motion either"
                     : "; none of the " + std::to_string(others) + " other assembly modes found can make this motion";
}

}  // namespace

MotionOutcome find_outcome_in_mode(const Mechanism& mechanism, const Trajectory& trajectory,
                                   const std::vector<double>& coordinates) {
  Mechanism assembled = mechanism;
  assembled.assembly.clear();
  for (std::size_t c = 0; c < coordinates.size(); ++c)
    assembled.assembly.push_back({static_cast<int>(c), coordinates[c]});
  Trajectory coarse = trajectory;
  coarse.samples = 2;
  return simulate(assembled, coarse).outcome;
}

std::string describe_feasible_modes(const Mechanism& mechanism, const Trajectory& trajectory,
                                    const MotionOutcome& outcome) {
  if (!depends_on_assembly_mode(outcome.status) || has_velocity_constraints(mechanism) ||
      is_mechanism_dependent(trajectory))
    return "";
  if (const std::string missed = kinematics::describe_unreachable_pose(mechanism, trajectory.to); !missed.empty())
    return "; the end pose cannot be reached: " + missed;
  return kinematics::dispatch_space(mechanism.space,
                                    [&]<class S>(S) { return describe_feasible_modes_in<S>(mechanism, trajectory); });
}

}  // namespace balance::simulation
