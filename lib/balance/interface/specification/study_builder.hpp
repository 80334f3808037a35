#pragma once
/// The study while its spec is being read, and the readers of numbers, points and names that all sections share.

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/types.hpp"
#include "balance/foundation/expression/expression.hpp"
#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/spec_parameters.hpp"
#include "balance/interface/specification/spec_units.hpp"
#include "balance/motion/study/spec_expressions.hpp"
#include "balance/motion/study/study.hpp"

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace balance::specification {

/// Indices of names in a list, for thousands of lookups.
class NameIndex {
 public:
  /// @param list of named elements, which may change from one call to the next
  /// @return index of the first one with that name; −1 if there is none
  template <class Named>
  int find(const std::vector<Named>& list, const std::string& name) {
    if (const int index = find_cached(name);
        index >= 0 && index < static_cast<int>(list.size()) && list[index].name == name)
      return index;
    indices_.clear();
    for (std::size_t i = 0; i < list.size(); ++i) indices_.emplace(list[i].name, static_cast<int>(i));
    return find_cached(name);
  }

 private:
  int find_cached(const std::string& name) const {
    const auto match = indices_.find(name);
    return match == indices_.end() ? -1 : match->second;
  }

  std::unordered_map<std::string, int> indices_;
};

// Values over time, from tables in the spec or beside it.

/// Rows of values in SI at increasing times [s].
struct TimeTable {
  std::vector<Expression> time;
  std::vector<int> columns;                     ///< indices into the possible columns, in the table's order
  std::vector<std::vector<Expression>> values;  ///< one row per time, one entry per column
};

using Vector3E = Vector3Of<Expression>;
using Matrix3E = Matrix3Of<Expression>;

/// Places of a body's mass and inertia in the spec.
struct BodyKeys {
  std::optional<SpecCursor> mass, inertia;
};

/// `positive_or_zero`: positive, or a zero that is checked elsewhere.
enum class SignConstraint { none, not_negative, positive, positive_or_zero };

/// A number that `design: for` names.
struct LoadParameterEntry {
  std::string path;
  double unit = 1;  ///< SI value of the spec's unit there
  SignConstraint sign = SignConstraint::none;
  std::optional<Expression> input;  ///< none if it is free
};

/// Free numbers that must have different sizes, by their paths.
struct DifferentPaths {
  std::vector<std::string> paths;
  std::vector<double> taken;  ///< values of fixed numbers among them
};

/// A number that `tolerances` names.
struct ToleranceEntry {
  std::string path;
  double value = 0;  ///< [SI]
  double unit = 1;   ///< SI value of the spec's unit there
  SignConstraint sign = SignConstraint::none;
  Expression input;      ///< changes it
  Expression perturbed;  ///< the number itself, including the change
};

/// A spec is read and checked at the start values. With other values of the free numbers a mass may be zero, or two
/// points may coincide; that is checked elsewhere.
struct StudyBuilder {
  explicit StudyBuilder(const std::string& file_name) : problems(file_name) { study.spec_file = file_name; }

  Study study;
  SpecErrorCollector problems;
  Units units;
  std::map<std::string, Dimension> number_dimensions;  ///< of free numbers and of those that loads or tolerances name
  SpecParameters parameters;
  std::vector<FreeNumberEntry> free_numbers;   ///< without parameters
  bool is_mechanism_valid = false;             ///< no mistakes in the sections of the mechanism
  std::vector<NodeLocation> body_places;       ///< of the bodies' names, in the order of mechanism.bodies
  std::map<std::size_t, BodyKeys> body_texts;  ///< of bodies that could be read, by their index
  std::map<std::string, Expression> inputs;    ///< of free_numbers by key path: several trajectories may share a number
  std::set<std::string> requested_inputs;      ///< key paths of other numbers that become inputs
  std::set<std::string> load_names;            ///< under `design: for`
  std::vector<LoadParameterEntry> load_numbers;  ///< numbers of the mechanism with one of these names
  std::set<std::string> adapted;                 ///< paths of free numbers under `design: adapt`
  std::vector<DifferentPaths> all_different;     ///< under `design: all_different`
  std::shared_ptr<study::Recording> recording = std::make_shared<study::Recording>();

  std::vector<std::pair<SpecCursor, double>>
      payload_activations;  ///< temporary payloads: their place in the spec, and when they appear [s]

  std::map<std::string, Expression> materials;  ///< densities of the spec's own materials [kg/m^3]

  std::vector<const YamlNode*> catalogue_nodes;  ///< values of `catalogue`, of each of study.catalogue_choices

  std::vector<model::CouplingOf<Expression>> rolling_couplings;  ///< of rolling joints: the slide follows the angle

  /// Springs of bushings, and dampers of these and of springs in joints: add_dampers().
  std::vector<model::SpringOf<Expression>> added_springs;
  std::vector<model::FrictionOf<Expression>> dampers;

  mutable NameIndex bodies, coordinates;  ///< of the mechanism's lists

  std::set<std::string> tolerance_names;          ///< under `tolerances`
  std::vector<ToleranceEntry> tolerance_numbers;  ///< without parameters

  MechanismOf<Expression>& mechanism() { return recording->mechanism; }
  const MechanismOf<Expression>& mechanism() const { return recording->mechanism; }
  std::vector<TrajectoryOf<Expression>>& trajectories() { return recording->trajectories; }
  bool planar() const { return mechanism().space == SpaceKind::planar; }
  /// Adds an input to the recording.
  Expression add_input(double value);
};

/// A number, an expression or a free number, in SI.
Expression read_number(const SpecCursor& at, StudyBuilder& draft, Dimension dimension,
                       SignConstraint sign = SignConstraint::none);
/// Whether the value is zero and no free number can change it: a start in the middle of symmetric bounds is zero, too.
bool is_fixed_zero(const SpecCursor& at, const Expression& value, const StudyBuilder& draft);
/// `{free: [lower, upper], <count key>: n}`: a list of free numbers.
/// @param count_numbers maps a count to a number of numbers; fails at it if the count is not allowed
std::vector<Expression> read_free_list(const SpecCursor& at, StudyBuilder& draft, Dimension dimension,
                                       const char* count_key,
                                       const std::function<long(const SpecCursor&, long)>& count_numbers);
/// Duration of a motion.
Expression read_duration(const SpecCursor& at, StudyBuilder& draft);
/// Fails unless a motion may have this duration [s].
void check_duration(const SpecCursor& at, double duration);
/// A list of numbers of one dimension. @param what for the message: "three numbers"
std::vector<Expression> read_numbers(const SpecCursor& at, StudyBuilder& draft, Dimension dimension,
                                     const std::string& what);
/// Two numbers in the plane (z = 0), three in space.
Vector3E read_vector(const SpecCursor& at, StudyBuilder& draft, Dimension dimension);
/// A nonzero vector, normalised; x if evaluated at numbers that make it zero.
Vector3E read_direction(const SpecCursor& at, StudyBuilder& draft);
/// A whole number, which cannot be free.
long read_integer(const SpecCursor& at, StudyBuilder& draft, long minimum, long maximum);
/// [roll, pitch, yaw]: Rz(yaw) Ry(pitch) Rx(roll).
Matrix3E read_rpy(const SpecCursor& at, StudyBuilder& draft);
/// [w, x, y, z], normalised; no rotation if evaluated at numbers that make it zero.
Matrix3E read_quaternion(const SpecCursor& at, StudyBuilder& draft);

/// A body's name. @return its index
BodyId read_body(const SpecCursor& at, const StudyBuilder& draft);

struct PointReference {
  BodyId body = 0;
  std::string name;
  Vector3E position = Vector3E::Zero();
};
/// `body.point`.
PointReference read_reference(const SpecCursor& at, const StudyBuilder& draft);
/// A position on a known body: the name of one of its points (`H` or `body.H`) or its coordinates.
/// @param body std::nullopt if it could not be read
Vector3E read_position(const SpecCursor& at, StudyBuilder& draft, std::optional<BodyId> body);
/// A coordinate's name. @return its index
CoordinateId read_coordinate(const SpecCursor& at, const StudyBuilder& draft);
/// The same for a name that has no node of its own (a key, a column).
CoordinateId find_coordinate(const SpecCursor& at, const std::string& name, const StudyBuilder& draft);
/// A coordinate's name, or `{J1: 1, J2: -0.5}`: ratios of the follower, which has this
/// dimension, to several coordinates.
model::CoordinateCombinationOf<Expression> read_followed(const SpecCursor& at, StudyBuilder& draft,
                                                         const Dimension& follower);
/// Whether a mapping's `follows` has ratios of its own; its `ratio` is then a common factor.
bool has_several_leaders(const SpecCursor& map);
/// Lists the coordinates of the joints read so far.
void list_joint_coordinates(StudyBuilder& draft);
/// `{J1: 0.3, J2: …}`: values of coordinates, each in its own unit.
std::vector<model::CoordinateValueOf<Expression>> read_coordinate_values(const SpecCursor& at, StudyBuilder& draft);

// Directions and rotations as expressions.

/// Selects entry by entry.
template <class Derived>
Eigen::Matrix<Expression, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime> choose(
    const Expression& condition, const Eigen::MatrixBase<Derived>& yes, const Eigen::MatrixBase<Derived>& no) {
  Eigen::Matrix<Expression, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime> result;
  for (Eigen::Index j = 0; j < result.cols(); ++j)
    for (Eigen::Index i = 0; i < result.rows(); ++i) result(i, j) = expression::select(condition, yes(i, j), no(i, j));
  return result;
}

/// v / |v|, without a check for zero.
Vector3E normalized(const Vector3E& v);
/// Rotation about a coordinate axis: 0, 1 or 2.
Matrix3E rotation_about(int axis, const Expression& angle);
/// Rz(yaw) Ry(pitch) Rx(roll) for (roll, pitch, yaw).
Matrix3E rotation_from_rpy(const Vector3E& rpy);
/// exp(skew(v)).
Matrix3E rotation_from_vector(const Vector3E& v);
/// From (w, x, y, z), normalised first.
Matrix3E rotation_from_quaternion(const std::vector<Expression>& q);

Matrix3 values_of(const Matrix3E& matrix);
Vector3 values_of(const Vector3E& vector);

/// Readers of the sections of a spec. Each reads its own key's value into the draft and collects mistakes; each may
/// rely on the sections above it.
void read_ground(const SpecCursor& section, StudyBuilder& draft);
void read_bodies(const SpecCursor& section, StudyBuilder& draft);
void read_joints(const SpecCursor& section, StudyBuilder& draft);
/// Checks that joints connect every body to the ground.
void check_connected(StudyBuilder& draft);
/// Checks that bodies without mass, and points, carry something. Call it once everything that
/// they may carry has been read.
void check_massless_bodies(StudyBuilder& draft);
void read_couplings(const SpecCursor& section, StudyBuilder& draft);
void read_actuators(const SpecCursor& section, StudyBuilder& draft);
void read_torque_distribution(const SpecCursor& section, StudyBuilder& draft);
void read_current_gains(const SpecCursor& section, StudyBuilder& draft);
void read_tool(const SpecCursor& section, StudyBuilder& draft);
/// Sums of speeds in which the equation of motion is requested, at their start values.
std::vector<model::GeneralisedSpeed> read_speeds(const SpecCursor& section, StudyBuilder& draft);
/// Sums of speeds that must be zero.
void read_constraints(const SpecCursor& section, StudyBuilder& draft);
void read_attachments(const SpecCursor& section, StudyBuilder& draft, AttachmentKind kind);
void read_discs(const SpecCursor& section, StudyBuilder& draft);
void read_loads(const SpecCursor& section, StudyBuilder& draft);
void read_springs(const SpecCursor& section, StudyBuilder& draft);
void read_dampers(const SpecCursor& section, StudyBuilder& draft);
/// A spring that has a `table` instead of a stiffness.
void read_tabulated_spring(const SpecCursor& at, const std::string& name, StudyBuilder& draft);
/// The damper beside a spring between points. @param damping its coefficient
void add_spring_damper(const SpecCursor& damping, const model::SpringOf<Expression>& spring, StudyBuilder& draft);
void read_friction(const SpecCursor& section, StudyBuilder& draft);
/// `motion` and `trajectories` together: `motion` has defaults for all trajectories.
void read_trajectories(const SpecCursor* motion, const SpecCursor* trajectories, StudyBuilder& draft);
/// @param root, overrides of the whole spec, for a controller's model of the mechanism. Null
/// section: only the built-in ones.
void read_controllers(const SpecCursor* section, const YamlNode& root, const SpecParameters::Overrides& overrides,
                      StudyBuilder& draft);
void read_design(const SpecCursor& section, StudyBuilder& draft);

// Ends of joints, and of springs between points.

/// `[body.point, body.point]`, of two bodies: the ends of a joint or a spring.
template <class Connection>
void read_connection_points(const SpecCursor& at, StudyBuilder& draft, Connection& connection) {
  const auto ends = at.items("two points [body.point, body.point]", 2);
  PointReference first, second;
  const bool first_read = draft.problems.collect([&] { first = read_reference(ends[0], draft); });
  const bool second_read = draft.problems.collect([&] { second = read_reference(ends[1], draft); });
  if (!first_read || !second_read) return;
  if (first.body == second.body)
    at.fail({.expected = "points of two bodies",
             .found = "two points of " +
                      quote_for_message(draft.mechanism().bodies[static_cast<std::size_t>(first.body)].name)});
  connection.first = first.body;
  connection.second = second.body;
  connection.point_first = first.position;
  connection.point_second = second.position;
}

}  // namespace balance::specification
