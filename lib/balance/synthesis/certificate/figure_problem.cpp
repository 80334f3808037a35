#include "balance/synthesis/certificate/figure_problem.hpp"

#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/mechanism_conversion.hpp"
#include "balance/mechanics/trajectory/trajectory_conversion.hpp"
#include "balance/synthesis/certificate/loop_closures.hpp"
#include "balance/synthesis/certificate/mechanism_enclosure.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace balance::certificate {
namespace {

constexpr long max_bounded_samples = 20'000;

class FigureProblemReader {
 public:
  FigureProblemReader(const DesignSpace& space, const FigureRequest& request)
      : space_(space), request_(request), dependence_(space) {}

  FigureProblem read() {
    result_.figures = request_.figures;
    result_.trajectory = request_.trajectory;
    LengthBox box = list_number_bounds(space_);
    result_.lower = std::move(box.lower);
    result_.upper = std::move(box.upper);
    result_.reason = find_obstacle();
    if (!result_.reason.empty()) return std::move(result_);
    count_uses();
    list_elements();
    list_lengths();
    if (result_.reason.empty()) result_.reason = find_moving_target();
    if (result_.reason.empty()) result_.reason = find_moving_point();
    if (result_.reason.empty()) read_goals();
    if (result_.reason.empty()) read_limits();
    return std::move(result_);
  }

 private:
  const Trajectory& trajectory() const {
    return space_.start.trajectories[static_cast<std::size_t>(request_.trajectory)];
  }

  bool has_torque() const {
    return std::any_of(request_.figures.begin(), request_.figures.end(),
                       [](const ForceFigure& figure) { return figure.force.kind == MotionForce::Kind::torque; });
  }

  std::string find_obstacle() {
    const Mechanism& mechanism = space_.start.mechanism;
    if (mechanism.space != SpaceKind::planar) return "only planar linkages are bounded";
    const auto has_sizes = [](const FreeNumber& number) { return !number.discrete_values.empty(); };
    if (std::all_of(space_.start.free_numbers.begin(), space_.start.free_numbers.end(), has_sizes))
      return "all free numbers have sizes, of which every combination can be tried";
    if (!result_.lower.allFinite() || !result_.upper.allFinite()) return "a free number has no bounds";
    if (has_velocity_constraints(mechanism)) return "something rolls, or speeds are constrained";
    if (!space_.start.design.cardinality.empty()) return "elements may be left out";
    if (has_torque() && (!mechanism.springs.empty() || !mechanism.force_elements.empty() ||
                         !mechanism.friction.empty() || !mechanism.loads.empty()))
      return "springs, dampers, friction and loads are not part of its model";
    for (const Attachment& attachment : mechanism.attachments)
      if (std::isfinite(attachment.from) || std::isfinite(attachment.until))
        return "a payload is taken up or set down on the way";
    return read_drive();
  }

  /// The values that are prescribed must be numbers of the spec, and not measured at a pose.
  std::string read_drive() {
    const Trajectory& motion = trajectory();
    if (motion.drive == DriveKind::com) return "the centre of mass is driven";
    if (is_mechanism_dependent(motion)) return "the law of the motion depends on the masses";
    if (!motion.secondary_tasks.empty()) return "the motion has a secondary task";
    if (motion.samples > max_bounded_samples) return "the motion has too many samples";
    trajectory::DriveQuantities quantities;
    try {
      const kinematics::CompiledMotion<kinematics::Planar> compiled(space_.start.mechanism, motion);
      if (compiled.plan.outcome.status != MotionStatus::done) return "the start values cannot follow the motion";
      if (compiled.tree.closure_rows > 0 && !(request_.keeps_assembly_mode && space_.assembly_mode))
        return "designs may be in any assembly mode";
      if (compiled.plan.has_redundant_closures) return "its loops are over-constrained";
      if (has_torque() && static_cast<int>(space_.start.mechanism.actuators.size()) != compiled.plan.freedoms)
        return "there are not as many actuators as degrees of freedom";
      quantities = compiled.plan.quantities;
    } catch (const std::invalid_argument&) {
      return "the motion does not suit the mechanism";
    }
    if (quantities.tool_angle || !quantities.com.empty()) return "the angle of the tool is driven";
    if (!quantities.point.empty() && !quantities.coordinates.empty()) return "tool and joints are driven together";
    result_.drive = {quantities.point, quantities.coordinates};
    const auto has_values = [&](const trajectory::PoseTarget& pose) { return gives_drive_values(pose); };
    if (std::holds_alternative<trajectory::TablePath>(motion.path)) return "";
    const auto* waypoints = std::get_if<trajectory::WaypointPath>(&motion.path);
    const bool is_circle = std::holds_alternative<trajectory::CirclePath>(motion.path);
    if (!has_values(motion.from) || (!is_circle && !has_values(motion.to)) ||
        (waypoints && !std::all_of(waypoints->points.begin(), waypoints->points.end(), has_values)))
      return "the motion's driven quantities are not all given as numbers, so that lengths change them";
    return "";
  }

  bool gives_drive_values(const trajectory::PoseTarget& pose) const {
    if (!result_.drive.point.empty()) return pose.tool.has_value();
    return std::all_of(result_.drive.coordinates.begin(), result_.drive.coordinates.end(), [&](CoordinateId driven) {
      return std::any_of(pose.joints.begin(), pose.joints.end(),
                         [&](const CoordinateValue& value) { return value.coordinate == driven; });
    });
  }

  /// How many expressions depend on each free number, and whether the motion's own do.
  void count_uses() {
    uses_.assign(space_.start.free_numbers.size(), 0);
    const auto count = [&](const Expression& expression) {
      for (const int number : dependence_.of(expression)) ++uses_[static_cast<std::size_t>(number)];
      return 0.0;
    };
    model::convert_mechanism<double>(space_.recording->mechanism, count);
    for (const auto& one : space_.recording->trajectories)
      trajectory::cast_scalar<double>(one, [&](const Expression& expression) {
        for (const int number : dependence_.of(expression)) moves_target_.insert(number);
        return 0.0;
      });
  }

  /// The free number that the expression is, if nothing else depends on it; else −1.
  int own_number(const Expression& expression) const {
    const int number = dependence_.number_of(expression);
    return number >= 0 && uses_[static_cast<std::size_t>(number)] == 1 && !moves_target_.contains(number) ? number : -1;
  }

  void list_elements() {
    const MechanismOf<Expression>& mechanism = space_.recording->mechanism;
    for (std::size_t i = 0; i < mechanism.attachments.size(); ++i) {
      const auto& attachment = mechanism.attachments[i];
      FreeElement element;
      element.attachment = static_cast<int>(i);
      element.mass_number = own_number(attachment.mass);
      element.place_numbers = {own_number(attachment.position[0]), own_number(attachment.position[1])};
      element.inertia_number = own_number(attachment.inertia(2, 2));
      element.is_added = attachment.kind == model::AttachmentKind::counterweight;
      add_element(element);
    }
    for (std::size_t i = 0; i < mechanism.discs.size(); ++i) {
      FreeElement element;
      element.disc = static_cast<int>(i);
      element.mass_number = own_number(mechanism.discs[i].mass);
      element.inertia_number = own_number(mechanism.discs[i].inertia(2, 2));
      element.is_added = true;
      add_element(element);
    }
  }

  void add_element(const FreeElement& element) {
    const bool is_free = element.mass_number >= 0 || element.place_numbers[0] >= 0 || element.place_numbers[1] >= 0 ||
                         element.inertia_number >= 0;
    if (is_free) result_.elements.push_back(element);
    for (const int number :
         {element.mass_number, element.place_numbers[0], element.place_numbers[1], element.inertia_number})
      if (number >= 0) is_of_element_.insert(number);
  }

  void list_lengths() {
    for (Eigen::Index i = 0; i < result_.lower.size(); ++i) {
      const int number = static_cast<int>(i);
      if (is_of_element_.contains(number) || !(result_.lower[i] < result_.upper[i])) continue;
      if (uses_[static_cast<std::size_t>(i)] == 0 && !moves_target_.contains(number)) continue;
      result_.lengths.push_back(number);
    }
    if (result_.lengths.empty()) result_.reason = "no length is free";
    if (result_.lengths.size() > IntervalJet::max_variables)
      result_.reason = "more than four free numbers are neither masses nor places of counterweights";
    for (Eigen::Index i = 0; i < result_.lower.size(); ++i)
      if (is_of_element_.contains(static_cast<int>(i)) && result_.lower[i] < 0 && is_mass(static_cast<int>(i)))
        result_.reason = "a mass may be negative";
  }

  bool is_mass(int number) const {
    return std::any_of(result_.elements.begin(), result_.elements.end(), [&](const FreeElement& element) {
      return element.mass_number == number || element.inertia_number == number;
    });
  }

  std::string find_moving_target() const {
    for (const int length : result_.lengths)
      if (moves_target_.contains(length)) return "a trajectory depends on a free number";
    return "";
  }

  std::string find_moving_point() const {
    const bool has_named_point = std::any_of(request_.figures.begin(), request_.figures.end(),
                                             [](const ForceFigure& figure) { return figure.force.has_named_point; });
    for (const auto& point : space_.recording->mechanism.bodies[model::ground].points)
      for (const Expression& coordinate : point.position)
        if (has_named_point && !dependence_.of(coordinate).empty())
          return "the point of the shaking moment may depend on a length";
    return "";
  }

  void read_goals() {
    using Kind = MotionForce::Kind;
    for (const Goal& goal : space_.start.design.goals) {
      const bool has_force = study::requires_zero_momentum(goal);
      const bool has_moment = has_force && study::requires_zero_angular_momentum(goal);
      if (has_force) result_.vanishing.push_back({.kind = Kind::shaking_force});
      if (has_moment) result_.vanishing.push_back({.kind = Kind::shaking_moment});
      if (!has_force) result_.ignored.push_back("the goal");
    }
  }

  void read_limits() {
    for (const study::FigureLimit& limit : space_.start.design.subject_to) {
      const bool is_added_mass = limit.terms.size() == 1 && !limit.is_lower &&
                                 limit.terms[0].size == ObjectiveTerm::Size::added_mass && limit.terms[0].weight > 0;
      if (is_added_mass) {
        const double bound = limit.bound / limit.terms[0].weight;
        result_.max_added_mass = std::min(bound, result_.max_added_mass.value_or(bound));
      } else {
        result_.ignored.push_back("\"" + limit.text + "\"");
      }
    }
  }

  const DesignSpace& space_;
  const FigureRequest& request_;
  NumberDependence dependence_;
  std::vector<int> uses_;
  std::set<int> moves_target_, is_of_element_;
  FigureProblem result_;
};

}  // namespace

int MotionForce::components(std::size_t actuators) const {
  if (kind == Kind::shaking_force) return component ? 1 : 2;
  if (kind == Kind::shaking_moment || actuator || !is_combined) return 1;
  return static_cast<int>(actuators);
}

int MotionForce::series(std::size_t actuators) const {
  return kind == Kind::torque && !actuator && !is_combined ? static_cast<int>(actuators) : 1;
}

FigureProblem read_figure_problem(const DesignSpace& space, const FigureRequest& request) {
  return FigureProblemReader(space, request).read();
}

}  // namespace balance::certificate
