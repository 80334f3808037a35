#pragma once
/// All quantities of a run that figures can be taken of, by name: the arrays of the run, motions of bodies and of the
/// tool, distances, springs. docs/compare.md lists them.

#include "balance/mechanics/model/landmark.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/result.hpp"

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::results {

/// A named point fixed to a body, whose motion has figures.
struct FigurePoint {
  std::string name;
  BodyId body = 0;
  Vector3 position = Vector3::Zero();  ///< in the body's axes [m]
};

/// A sampled scalar or vector of a run.
struct RunQuantity {
  std::string name, unit;               ///< the unit of a pure number is empty
  std::vector<std::string> components;  ///< their names; empty: a scalar without any
  std::function<Samples()> samples;     ///< one row per entry of `times`
  const VectorX* times = nullptr;
  std::vector<double> round_off;        ///< per component; empty: unknown
  bool is_kinematic = false;            ///< follows from the motion and the geometry alone
  Samples RunResult::*array = nullptr;  ///< whose columns it is, from `first` on; null: it is computed
  int first = 0;
};

/// The quantity that a name means, or one component of it.
struct NamedQuantity {
  const RunQuantity* quantity = nullptr;  ///< null: `mistake` says why
  int component = -1;                     ///< −1: the whole quantity
  std::string mistake;                    ///< "shaking_force has no component 'z', only x and y"

  bool is_scalar() const { return component >= 0 || quantity->components.size() < 2; }
  /// The scalars or the vector's components, one row per entry of the quantity's times.
  Samples samples() const;
  /// Of the component, or the largest of all.
  double round_off() const;
};

/// The quantities of one run, in which figures find both sides of every jump.
class RunQuantities {
 public:
  /// @param run with samples, or a single state: one row. Null: no quantities but those that are added
  /// @param mechanism of the run; null: the run has no motions of bodies. Both must outlive this object
  RunQuantities(const RunResult* run, const Mechanism* mechanism, std::vector<FigurePoint> points = {});
  RunQuantities(const RunQuantities&) = delete;
  RunQuantities& operator=(const RunQuantities&) = delete;

  /// The quantity of that name, such as "joint_force[B].x", "shaking_moment[z] about ground.P" or
  /// "distance[arm.A, ground.B]". A component is "[x]" or ".x" at the end.
  NamedQuantity find(const std::string& name);
  /// Adds a scalar that does not change with time; without effect if there is one of that name.
  void add_constant(std::string name, const std::string& unit, double value);
  const std::deque<RunQuantity>& list() const { return quantities_; }
  /// Of the run's rows and of its intermediate samples, ascending.
  const VectorX& times() const { return times_; }

 private:
  void list_run_quantities();
  void list_motion_quantities();
  void list_spring_quantities();
  void list_force_element_quantities();
  void add_moving_point(const std::string& position_name, const std::string& velocity_name,
                        const std::string& acceleration_name, BodyId body, const Vector3& position);
  void add_motion(std::string name, const char* unit, std::vector<std::string> components,
                  std::function<VectorX(const std::vector<BodyMotion>&)> value);
  void add_body_orientation(BodyId body);
  const std::vector<std::vector<BodyMotion>>& motions();
  bool is_merged(Samples RunResult::*array) const;
  Samples merge(Samples RunResult::*array, int first, int count) const;
  const RunQuantity* find_listed(const std::string& name) const;
  NamedQuantity find_with_component(const std::string& name);
  const RunQuantity* add_distance(const std::string& name, std::string& mistake);
  const RunQuantity* add_moment_about(const std::string& name, const RunQuantity& moment, const std::string& point,
                                      std::string& mistake);
  std::optional<model::BodyPoint> find_point(const std::string& name, std::string& mistake) const;

  const RunResult* run_;
  const Mechanism* mechanism_;
  std::vector<FigurePoint> points_;
  std::deque<RunQuantity> quantities_;
  std::vector<std::pair<const RunResult*, Eigen::Index>> rows_;  ///< of the run and its intermediate samples, in order
  VectorX times_, recorded_times_;
  std::vector<std::vector<BodyMotion>> motions_;  ///< per entry of rows_; empty: not computed
};

/// From a point to a line segment; to a point if both its ends are the same.
double distance_to_segment(const Vector3& point, const Vector3& begin, const Vector3& end);

// Parts of a quantity's name.

/// "shaking_moment[z] about ground.P" without " about ground.P", and the point; without it the point is empty.
std::pair<std::string, std::string> split_moment_point(const std::string& name);
/// "joint_force[B].x" or "joint_force[B][x]" without its last part, and "x"; both empty if there is no such part.
std::pair<std::string, std::string> split_component(const std::string& name);

/// What a quantity is, without a run.
struct QuantityDescription {
  std::string name;  ///< in its usual spelling: "force[S]" for "torque[S]", "shaking_force[x]" for "shaking_force.x"
  std::string unit;  ///< "1": a pure number
  bool is_scalar = true;      ///< has a sign; else a magnitude
  bool is_kinematic = false;  ///< as RunQuantity
};

/// @param mistake why there is none, if there is none
std::optional<QuantityDescription> describe_quantity(const Mechanism& mechanism, const std::string& name,
                                                     std::string& mistake);

/// Names of all quantities of a mechanism's runs, without components, distances and moments about other points.
std::vector<std::string> list_quantities(const Mechanism& mechanism);

/// Whether runs can be differentiated for the quantity: it is one of their arrays, or a component of one.
bool has_gradients(const Mechanism& mechanism, const std::string& quantity);

/// The columns of a run's array that the quantity, or the component of one, consists of; std::nullopt if it is computed
/// from others.
std::optional<MetricSeries> find_series(const RunResult& run, const std::string& quantity);

/// Statistic of a quantity of a run. "torque", "joint_force" and the like mean the worst of all actuators or joints.
/// @param mechanism of the run; null: no motions of bodies
/// @return NaN if there is no such quantity
double compute_statistic(const RunResult& run, const Mechanism* mechanism, Statistic statistic,
                         const std::string& quantity);

}  // namespace balance::results
