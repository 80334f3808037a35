#include "balance/synthesis/verification/mechanism_check.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/simulation/feasible_assembly_modes.hpp"

#include <algorithm>
#include <cmath>

namespace balance::verification {

namespace {

/// Maximum number of coordinates times steps in the search for assembly modes: a second or two. Mechanisms of a
/// thousand coordinates need less.
constexpr long max_assembly_search_work = 1'500'000;

/// Runs along trajectories that are tried in the modes, fewer for many coordinates: some tenths of a second. Where the law
/// has to be searched for, a run counts for several.
constexpr int max_motion_work = 1500, min_motion_runs = 3, max_motion_runs = 64, optimised_run_work = 8;

template <class S>
class MechanismChecker {
 public:
  MechanismChecker(const Study& study, const std::function<void(double)>& progress)
      : study_(study),
        progress_(progress),
        mechanism_(study.mechanism),
        tree_(kinematics::compile_tree<S>(mechanism_, list_required_coordinates(study))),
        start_equations_(make_pose_equations(mechanism_, tree_, start_pose())),
        system_(tree_, start_equations_.drive) {}

  CheckReport run() {
    count_elements();
    const kinematics::AssemblySolution start = solve_pose(mechanism_, tree_, system_, start_equations_.target);
    if (!start.found) {
      report_.outcome = explain_assembly_failure(mechanism_, tree_, start, start_pose());
      return report_;
    }
    compute_ranks(start.y);
    describe_start(start.y);
    find_modes(start.y);
    find_motions();
    check_actuators();
    report_.outcome.status = MotionStatus::done;
    return report_;
  }

 private:
  static std::vector<CoordinateId> list_required_coordinates(const Study& study) {
    return study.trajectories.empty() ? std::vector<CoordinateId>{}
                                      : prescribed_coordinates(study.trajectories.front());
  }

  /// The first trajectory's start pose; without trajectories, the actuators at their rough values.
  trajectory::PoseTarget start_pose() const {
    return study_.trajectories.empty() ? kinematics::actuators_as_assembled(mechanism_)
                                       : study_.trajectories.front().from;
  }

  void count_elements() {
    report_.bodies = static_cast<int>(mechanism_.bodies.size()) - 1;
    report_.joints = static_cast<int>(mechanism_.joints.size());
    report_.tree_coordinates = tree_.columns;
    report_.closure_equations = tree_.position_rows;
    report_.rate_equations = tree_.closure_rows - tree_.position_rows;
    report_.gruebler_degrees_of_freedom = count_degrees_of_freedom(mechanism_);
    report_.total_mass = tree_.mass;
    const model::SpanningTree spanning = build_spanning_tree(mechanism_, list_required_coordinates(study_));
    for (std::size_t j = 0; j < mechanism_.joints.size(); ++j)
      if (tree_.joint_nodes[j] >= 0) report_.tree_joints.push_back(mechanism_.joints[j].name);
    for (const kinematics::Closure<S>& closure : tree_.closures) {
      if (closure.is_velocity_level()) break;
      Loop loop;
      loop.cut_joint = mechanism_.joints[closure.joint].name;
      loop.constraints = static_cast<int>(closure.rows.size());
      for (const BodyId body : loop_bodies(mechanism_, spanning, closure.joint))
        loop.bodies.push_back(mechanism_.bodies[body].name);
      report_.loops.push_back(loop);
    }
  }

  void compute_ranks(const VectorX& y) {
    const int rank = find_generic_closure_rank(tree_, y);
    report_.closure_rank = report_.rate_equations > 0 ? find_generic_position_rank(tree_, y) : rank;
    report_.rate_rank = rank - report_.closure_rank;
    report_.configuration_freedoms = tree_.columns - report_.closure_rank;
    report_.degrees_of_freedom = tree_.columns - rank;
    if (tree_.closure_rows > rank) find_redundant_rows(y, rank);
    find_passive_freedoms();
  }

  /// Finds closure rows that depend on the others. Which rows of a dependent set these are is a choice: the last ones.
  void find_redundant_rows(const VectorX& y, int rank) {
    kinematics::ConstraintSystem<S> closures(tree_, kinematics::Drive<S>{});
    MatrixX jacobian;
    closures.velocity_jacobian(y, {}, jacobian);
    MatrixX independent_rows(0, tree_.columns);
    int r = 0;
    auto constraint = mechanism_.constraints.begin();
    for (const kinematics::Closure<S>& closure : tree_.closures) {
      const std::string name =
          closure.joint < 0 ? "constraint " + (constraint++)->name : mechanism_.joints[closure.joint].name;
      for (const kinematics::ClosureRow& row : closure.rows) {
        MatrixX extended_rows(independent_rows.rows() + 1, tree_.columns);
        extended_rows << independent_rows, jacobian.row(r++);
        if (independent_rows.rows() < rank && kinematics::decompose_rank(extended_rows).rank == extended_rows.rows())
          independent_rows = extended_rows;
        else
          report_.redundant.push_back(name + ": " + describe_row(row));
      }
    }
  }

  static std::string describe_row(const kinematics::ClosureRow& row) {
    static const char* const names[] = {"x", "y", "z"};
    if (row.kind == kinematics::ClosureRow::Kind::sum) return "its speed is zero anyway";
    if (row.kind == kinematics::ClosureRow::Kind::slip)
      return std::string("friction along ") + names[row.i] + " of the plane";
    if (row.kind == kinematics::ClosureRow::Kind::along)
      return std::string("force along ") + names[row.i] + " of the joint's axes";
    if (S::dimension == 2) return "moment";
    return std::string("moment about ") + names[3 - row.i - row.j] + " of the joint's axes";
  }

  void find_passive_freedoms() {
    for (const model::PassiveFreedom& spin : tree_.locked_freedoms)
      report_.passive_freedoms.push_back(
          mechanism_.bodies[spin.body].name + " could spin about the line between its spherical joints " +
          mechanism_.joints[spin.joints[0]].name + " and " + mechanism_.joints[spin.joints[1]].name +
          "; it is held as if one of them were universal, and not counted");
  }

  void describe_start(const VectorX& y) {
    report_.start = compute_coordinates(mechanism_, tree_, y);
    clear_pose_round_off(mechanism_, tree_.characteristic_length, report_.start);
    kinematics::TreeState<S> state(tree_.nodes.size());
    compute_poses(tree_, y.data(), state);
    kinematics::MassDistribution<S> masses(tree_);
    masses.update(tree_, state);
    report_.com = kinematics::to_3d(masses.com());
    for (double& component : report_.com)
      if (std::abs(component) < model::pose_round_off * tree_.characteristic_length) component = 0;
  }

  /// Other ways to close the loops at the same start pose.
  void find_modes(const VectorX& selected) {
    if (tree_.closures.empty() && start_equations_.drive.linear.size() == static_cast<std::size_t>(tree_.columns))
      return;
    kinematics::AssemblyModes<S> modes(mechanism_, tree_, system_, start_equations_.target, selected);
    const int restarts = tree_.columns > 100 ? 24 : std::clamp(6000 / (tree_.columns * tree_.columns + 1), 24, 400);
    long work = 0;
    for (int start = 1; start <= restarts; ++start) {
      if (work > max_assembly_search_work) {
        report_.notes.push_back("the search for assembly modes stopped after " + std::to_string(start - 1) + " of " +
                                std::to_string(restarts) + " random starts: the mechanism is large");
        break;
      }
      if (progress_) progress_(static_cast<double>(start - 1) / restarts);
      work += modes.search_from(static_cast<std::uint64_t>(start));
    }
    // a pose that leaves freedoms open has a continuum of solutions, not modes
    const bool is_isolated = start_equations_.drive.row_count() >= report_.configuration_freedoms;
    for (const std::vector<double>& mode : modes.modes()) {
      if (!is_isolated && !report_.modes.empty()) break;
      report_.modes.push_back({.coordinates = mode, .is_selected = report_.modes.empty()});
      clear_pose_round_off(mechanism_, tree_.characteristic_length, report_.modes.back().coordinates);
    }
    std::sort(report_.modes.begin() + 1, report_.modes.end(),
              [](const AssemblyMode& a, const AssemblyMode& b) { return a.coordinates < b.coordinates; });
    for (AssemblyMode& mode : report_.modes)
      mode.assembly_line = format_assembly_line(mechanism_, tree_, start_equations_.drive, mode.coordinates);
  }

  /// Which trajectories can be followed in which mode.
  void find_motions() {
    const std::vector<Trajectory>& trajectories = study_.trajectories;
    if (trajectories.empty() || report_.modes.empty()) return;
    int runs = std::clamp(max_motion_work / (tree_.columns * tree_.columns + 1), min_motion_runs, max_motion_runs);
    std::vector<MotionOutcome> selected;
    std::size_t tried = 0;
    for (; tried < report_.modes.size() && runs > 0; ++tried) {
      AssemblyMode& mode = report_.modes[tried];
      for (const Trajectory& trajectory : trajectories) {
        runs -= is_mechanism_dependent(trajectory) || trajectory.free_motion ? optimised_run_work : 1;
        const MotionOutcome outcome = simulation::find_outcome_in_mode(mechanism_, trajectory, mode.coordinates);
        if (outcome.status == MotionStatus::done) mode.motions.push_back(trajectory.name);
        if (tried == 0) selected.push_back(outcome);
      }
    }
    const bool has_all = tried == report_.modes.size();
    if (!has_all)
      report_.notes.push_back("the trajectories were tried in " + std::to_string(tried) + " of " +
                              std::to_string(report_.modes.size()) + " assembly modes");
    for (std::size_t k = 0; k < trajectories.size(); ++k)
      if (std::none_of(report_.modes.begin(), report_.modes.end(), [&](const AssemblyMode& mode) {
            return std::find(mode.motions.begin(), mode.motions.end(), trajectories[k].name) != mode.motions.end();
          }))
        report_.notes.push_back(std::string("no assembly mode that was ") + (has_all ? "found" : "tried") +
                                " can follow " + trajectories[k].name + ": " + selected[k].reason +
                                describe_unreachable_end(trajectories[k], selected[k]));
  }

  /// "; the end pose cannot be reached: …", if that may be why a motion fails on its way.
  std::string describe_unreachable_end(const Trajectory& trajectory, const MotionOutcome& outcome) const {
    if (outcome.reason.find("out of reach") != std::string::npos || has_velocity_constraints(mechanism_)) return "";
    const std::string missed = kinematics::describe_unreachable_pose(mechanism_, trajectory.to);
    return missed.empty() ? "" : "; the end pose cannot be reached: " + missed;
  }

  void check_actuators() {
    const dynamics::Actuation<S> actuation(mechanism_, tree_, report_.degrees_of_freedom);
    const auto& trajectories = study_.trajectories;
    const bool is_partly_driven =
        !trajectories.empty() && std::all_of(trajectories.begin(), trajectories.end(),
                                             [](const Trajectory& motion) { return motion.free_motion.has_value(); });
    if (!actuation.mismatch().empty() && !is_partly_driven) report_.notes.push_back(actuation.mismatch());
    report_.notes.insert(report_.notes.end(), actuation.notes().begin(), actuation.notes().end());
    if (start_equations_.drive.row_count() < report_.degrees_of_freedom)
      report_.notes.push_back("the start pose states " + std::to_string(start_equations_.drive.row_count()) +
                              " values for " + std::to_string(report_.degrees_of_freedom) + " degrees of freedom");
    else if (start_equations_.drive.row_count() < report_.configuration_freedoms)
      report_.notes.push_back("the start pose states " + std::to_string(start_equations_.drive.row_count()) + " of " +
                              std::to_string(report_.configuration_freedoms) +
                              " values; the others are those of 'assembly', or the nearest to them");
  }

  const Study& study_;
  const std::function<void(double)>& progress_;
  const Mechanism& mechanism_;
  kinematics::Tree<S> tree_;
  kinematics::PoseEquations<S> start_equations_;
  kinematics::ConstraintSystem<S> system_;
  CheckReport report_;
};

}  // namespace

CheckReport check_mechanism(const Study& study, const std::function<void(double)>& progress) {
  CheckReport report = kinematics::dispatch_space(
      study.mechanism.space, [&]<class S>(S) { return MechanismChecker<S>(study, progress).run(); });
  if (report.outcome.status == MotionStatus::done && !(report.com.allFinite() && std::isfinite(report.total_mass)))
    report.outcome = trajectory::make_overflow_outcome(0, "the centre of mass", study.mechanism);
  report.rotors = simulation::list_rotor_unbalances(study.mechanism, study.trajectories);
  report.vibrations = vibration::find_vibration_modes(study);
  for (const study::TemporaryPayload& payload : study.temporary_payloads)
    report.notes.push_back("payload '" + payload.name + "' is not always there; mass and centre of mass include it");
  return report;
}

}  // namespace balance::verification
