#pragma once
/// The papers' equations of a mechanism as numbers, at one configuration or along a run.

#include "balance/mechanics/dynamics/equation_terms.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"
#include "balance/synthesis/verification/natural_terms.hpp"

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace balance::formulas {

/// Parts of the report that can be requested.
enum class EquationSection { inertia, velocity, gravity, torques, redundant, natural, regressor, parameters };

/// "inertia", "velocity", …, in the enum's order.
const std::vector<std::string>& equation_section_names();

struct EquationsQuery {
  std::vector<CoordinateValue> configuration;         ///< of all coordinates, with the loops closed
  std::vector<CoordinateValue> rates, accelerations;  ///< of independent coordinates; others are 0
  double time = 0;                       ///< for loads that change over time and for temporary payloads [s]
  std::vector<std::string> independent;  ///< see InverseOptions
  model::SpeedChoice speeds;             ///< if not empty, the equation is also given in these speeds
  std::set<EquationSection> sections;
};

/// Results at one configuration; what was not requested, or does not exist there, is empty.
struct EquationsAtConfiguration {
  std::vector<std::string> independent;  ///< d names
  std::vector<bool> is_length;           ///< per independent coordinate: whether it is a length
  std::vector<std::string> redundant;    ///< n names
  std::vector<std::string> closures;     ///< per closure row: its joint
  std::vector<std::string> disc_rows;    ///< per row of RedundantTerms::discs
  std::vector<std::string> actuators;
  std::vector<bool> is_force;  ///< per actuator: whether its effort is a force
  VectorX configuration;       ///< of all coordinates of the mechanism
  VectorX q, dq, ddq;
  std::optional<dynamics::IndependentTerms> terms;
  std::optional<dynamics::SpeedTerms> in_speeds;
  bool has_rate_constraints =
      false;  ///< its rates are constrained: the configuration has more freedoms than `independent`
  std::vector<std::string> speeds, zero;  ///< names of the speeds, and of those that are held
  bool has_constraint_values = false;     ///< some of those that are held have a value other than zero
  std::optional<dynamics::RedundantTerms> loops;
  std::optional<dynamics::EffortBreakdown> split;
  std::optional<dynamics::EffortRegressor> regressor;
  std::optional<verification::natural::NaturalTerms> natural;
  std::optional<Conditions> parameters;  ///< result of compute_base_parameters
  conditions::ConditionNames parameter_names;
  double torque_scale =
      0;  ///< weight of everything that moves times the mechanism's length [N m]: reference for round-off of forces
  std::optional<VectorX> diagonal_factors;  ///< k of u_k = k q̈_k, if only a diagonal M′ remains there (P1 eq. 27, 28)
  std::vector<std::string> notes;
};

struct EquationsReport {
  MotionOutcome outcome;  ///< done, or why there are no equations there
  EquationsAtConfiguration at;
};

/// @param symbols in which base parameters are written; empty: numbers only
/// @throws std::invalid_argument for coordinates that do not exist or do not determine the motion
EquationsReport compute_equations_at(const Mechanism& mechanism, const EquationsQuery& query,
                                     const std::vector<conditions::GeometricSymbol>& symbols);

/// The matrices at every sample of a run. Row k belongs to result.time[k]; matrices are stored row by row.
struct EquationsAlongRun {
  MotionOutcome outcome;
  std::vector<std::string> independent, redundant, closures, disc_rows;
  VectorX time;            ///< N [s]
  Samples position;        ///< N×d: the independent coordinates
  Samples mass;            ///< N×(d d)
  Samples velocity;        ///< N×(d d d)
  Samples viscous;         ///< N×(d d)
  Samples static_terms;    ///< N×d
  Samples transformation;  ///< N×(n d)
  Samples discs;           ///< N×(disc rows d)
  Samples rate_offset;     ///< N×n; empty unless constraints prescribe speeds
  Samples constraints;     ///< N×(closure rows n)
  Samples parts;           ///< N×(actuators parts); empty if there is no breakdown of the efforts
};

/// @param at must have terms and loops
EquationsAlongRun as_one_sample(const EquationsAtConfiguration& at);

/// @param result a successful run of this mechanism
EquationsAlongRun compute_equations_along(const Mechanism& mechanism, const RunResult& result,
                                          const std::vector<std::string>& independent);

}  // namespace balance::formulas
