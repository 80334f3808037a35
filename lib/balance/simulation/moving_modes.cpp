#include "balance/simulation/moving_modes.hpp"

#include "balance/kinematics/assembly_modes.hpp"
#include "balance/motion/names.hpp"
#include "balance/motion/plan.hpp"
#include "balance/simulation/simulate.hpp"

#include <algorithm>

namespace balance {

namespace {

constexpr std::uint64_t mode_starts = 60;
constexpr int max_mode_columns = 60;  // of larger mechanisms the search takes longer than anybody waits for a message
constexpr std::size_t max_modes_run = 16;

bool is_matter_of_modes(MotionStatus status) {
  using enum MotionStatus;
  return status == unreachable || status == drive_singularity || status == assembly_jump ||
         status == constraint_singularity || status == actuation_singularity;
}

/// Whether the motion can be made from there. The run has two samples.
template <class S>
bool moves(const Mechanism& mechanism, const Trajectory& trajectory, const Tree<S>& tree,
           const std::vector<double>& mode) {
  Mechanism assembled = mechanism;
  assembled.assembly.clear();
  for (std::size_t c = 0; c < mode.size(); ++c)
    if (tree.sources[c].depends()) assembled.assembly.push_back({static_cast<int>(c), mode[c]});
  Trajectory coarse = trajectory;
  coarse.samples = 2;
  return simulate(assembled, coarse).outcome.status == MotionStatus::done;
}

template <class S>
std::string text_of_modes(const Mechanism& mechanism, const Trajectory& trajectory) {
  const Tree<S> tree = compile<S>(mechanism, prescribed_coordinates(trajectory));
  if (tree.closures.empty() || tree.columns > max_mode_columns) return "";
  const PoseEquations<S> from = pose_equations(mechanism, tree, trajectory.from);
  System<S> system(tree, from.drive);
  const Solution selected = find_pose(mechanism, tree, system, from.target);
  // a pose that leaves freedoms open has a continuum of solutions, not modes
  if (!selected.found || from.drive.rows() < tree.columns - generic_place_rank(tree, selected.y)) return "";
  AssemblyModes<S> modes(mechanism, tree, system, from.target, selected.y);
  for (std::uint64_t start = 1; start <= mode_starts; ++start) modes.search_from(start);
  const std::size_t others = modes.all().size() - 1;
  if (others == 0) return "";
  for (std::size_t m = 1; m < std::min(modes.all().size(), max_modes_run); ++m)
    if (moves(mechanism, trajectory, tree, modes.all()[m]))
      return "; another assembly mode can make this motion: " +
             assembly_line(mechanism, tree, from.drive, modes.all()[m]);
  return others == 1 ? "; the other assembly mode cannot make this motion either"
                     : "; none of the " + std::to_string(others) + " other assembly modes found can make this motion";
}

}  // namespace

std::string moving_modes_text(const Mechanism& mechanism, const Trajectory& trajectory, const MotionOutcome& outcome) {
  if (!is_matter_of_modes(outcome.status) || binds_rates(mechanism) || depends_on_mechanism(trajectory)) return "";
  return in_space(mechanism.space, [&]<class S>(S) { return text_of_modes<S>(mechanism, trajectory); });
}

}  // namespace balance
