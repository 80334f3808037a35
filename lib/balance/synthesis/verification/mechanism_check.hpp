#pragma once
/// Structure and mobility of a mechanism, before anything moves.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/simulation/rotor_unbalance.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/motion/vibration/vibration_modes.hpp"

#include <functional>
#include <string>
#include <vector>

namespace balance::verification {

/// One way to assemble the mechanism at its start pose.
struct AssemblyMode {
  std::vector<double> coordinates;  ///< of all joints, in the order of Mechanism::coordinates; angles in (−π, π]
  std::string assembly_line;        ///< `assembly: {B1: -1.6, B2: -2.8}`: selects this mode if pasted into the spec
  bool is_selected = false;         ///< the mode that the spec currently selects
  std::vector<std::string> motions = {};  ///< trajectories that can be followed from it without a singularity
};

struct Loop {
  std::string cut_joint;            ///< the joint at which the loop is closed
  std::vector<std::string> bodies;  ///< around the loop
  int constraints = 0;              ///< closure equations
};

struct CheckReport {
  MotionOutcome outcome;  ///< done, or why the mechanism cannot be assembled
  int bodies = 0;         ///< moving bodies
  int joints = 0;
  std::vector<std::string> tree_joints;  ///< joints of the spanning tree, whose coordinates are the generalised ones
  std::vector<Loop> loops;
  int tree_coordinates = 0;  ///< that remain after couplings are substituted
  int closure_equations = 0;
  int closure_rank = 0;
  int rate_equations = 0;               ///< velocity constraints: rolling on a plane, and the spec's
  int rate_rank = 0;                    ///< number of these that are independent of each other and of the closures
  int configuration_freedoms = 0;       ///< by rank: coordinates minus independent closure equations
  int degrees_of_freedom = 0;           ///< by rank: configuration_freedoms minus independent rate equations
  int gruebler_degrees_of_freedom = 0;  ///< Grübler–Kutzbach
  std::vector<std::string> redundant;   ///< one line per redundant constraint: "D1: moment about x of the loop …"
  std::vector<std::string>
      passive_freedoms;  ///< spins that affect nothing else, held and not counted: "rod1 could spin about the line …"
  double total_mass = 0;          ///< [kg]
  Vector3 com = Vector3::Zero();  ///< at the start pose [m]
  std::vector<double> start;      ///< coordinates at the start pose
  std::vector<AssemblyMode>
      modes;  ///< found at the start pose; large mechanisms have fewer random starts (a note says how many)
  std::vector<simulation::RotorUnbalance> rotors;     ///< with the payloads that come and go
  std::vector<vibration::VibrationModes> vibrations;  ///< of trajectories with free coordinates
  std::vector<std::string> notes;
};

/// @param study its first trajectory's `from` is the start pose; without trajectories the actuated coordinates are held
/// at their assembly values (or zero)
/// @param progress called from time to time with the completed fraction of the search for assembly modes, 0 to 1
CheckReport check_mechanism(const Study& study, const std::function<void(double fraction)>& progress = {});

}  // namespace balance::verification

namespace balance {

using verification::check_mechanism;
using verification::CheckReport;

}  // namespace balance
