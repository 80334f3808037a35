#include "balance/synthesis/certificate/loop_closures.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/model/couplings.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::certificate {
namespace {

/// Ends the reading with a reason.
struct NotPolynomial : std::runtime_error {
  using std::runtime_error::runtime_error;
};

using Coefficient = LengthPolynomial::Coefficient;

/// Of angles and ratios of gears, which are given numbers.
constexpr double gear_tolerance = 1e-9;
/// Relative to its terms: what is left of a coefficient that cancels.
constexpr double cancellation_tolerance = 1e-13;

Coefficient unit_vector(double angle) { return {elementary::cos(angle), elementary::sin(angle)}; }

template <class Predicate>
bool has_goal(const DesignSpace& space, const Predicate& is_wanted) {
  const std::vector<Goal>& goals = space.start.design.goals;
  return std::any_of(goals.begin(), goals.end(), is_wanted);
}

/// Static efforts vanish in the same mechanisms as shaking forces if all coordinates are actuated, there is gravity and
/// nothing else but masses asks for efforts.
void check_statics(const MechanismOf<Expression>& mechanism) {
  const auto is_zero = [](const Expression& g) { return g.is_constant() && g.value() == 0; };
  if (is_zero(mechanism.gravity[0]) && is_zero(mechanism.gravity[1])) throw NotPolynomial("there is no gravity");
  for (int i = 0; i < 3; ++i)
    if (!mechanism.gravity[i].is_constant()) throw NotPolynomial("gravity is not constant");
  if (!mechanism.springs.empty()) throw NotPolynomial("springs carry a part of the weight");
  if (!mechanism.force_elements.empty()) throw NotPolynomial("dampers or springs with a table act on it");
  if (!mechanism.loads.empty()) throw NotPolynomial("loads act on it");
  if (!mechanism.friction.empty()) throw NotPolynomial("joints have friction");
}

void check_request(const DesignSpace& space) {
  const study::DesignRequest& request = space.start.design;
  const MechanismOf<Expression>& mechanism = space.recording->mechanism;
  if (mechanism.space != SpaceKind::planar) throw NotPolynomial("the mechanism is not planar");
  const bool is_force = has_goal(space, study::requires_zero_momentum);
  if (!is_force && !requires_force_or_static_balance(space) && !requires_moment_balance(space))
    throw NotPolynomial("the goals require neither balanced forces nor balanced statics or moments");
  if (!is_force && requires_force_or_static_balance(space)) check_statics(mechanism);
  if (request.minimize.size() != 1 || request.front ||
      (request.minimize[0].size != ObjectiveTerm::Size::added_mass &&
       request.minimize[0].size != ObjectiveTerm::Size::total_mass) ||
      request.minimize[0].weight != 1)
    throw NotPolynomial("the objective is neither the added mass nor the total mass");
  if (request.cases.size() > 1 || !request.cases.numbers.empty()) throw NotPolynomial("there are several load cases");
  if (!mechanism.constraints.empty()) throw NotPolynomial("its speeds are constrained");
  for (const auto& joint : mechanism.joints)
    if (joint.type != JointType::revolute && joint.type != JointType::prismatic && joint.type != JointType::fixed &&
        joint.type != JointType::pin_slot)
      throw NotPolynomial("joint " + joint.name + " is neither revolute nor prismatic");
  for (const auto& attachment : mechanism.attachments)
    if (std::isfinite(attachment.from) || std::isfinite(attachment.until))
      throw NotPolynomial(attachment.name + " is not carried all the time");
}

/// The variable that a polynomial is; −1: it is another polynomial.
int find_plain_variable(const LengthPolynomial& p) {
  if (p.terms().size() != 1 || p.terms().begin()->second != LengthPolynomial::Coefficient(1)) return -1;
  const LengthPolynomial::Exponents& exponents = p.terms().begin()->first;
  int found = -1;
  for (std::size_t i = 0; i < exponents.size(); ++i) {
    if (exponents[i] == 0) continue;
    if (exponents[i] > 1 || found >= 0) return -1;
    found = static_cast<int>(i);
  }
  return found;
}

/// Whether forces of the ground's slides count only along gravity.
bool counts_statics_alone(const DesignSpace& space) {
  return requires_force_or_static_balance(space) && !has_goal(space, study::requires_zero_momentum);
}

bool lets_turn(JointType type) { return type == JointType::revolute || type == JointType::pin_slot; }
bool lets_slide(JointType type) { return type == JointType::prismatic || type == JointType::pin_slot; }

/// Sums of rates of angles and slides that couplings keep constant.
struct GearEquations {
  MatrixX angles;  ///< equations × directions
  MatrixX slides;  ///< equations × joints
  VectorX right;
};

class LinkageReader {
 public:
  LinkageReader(const DesignSpace& space, const LengthSubstitution& substitution, bool has_moments)
      : space_(space),
        mechanism_(space.recording->mechanism),
        variables_(static_cast<int>(space.start.free_numbers.size())) {
    std::vector<LengthPolynomial> inputs;
    for (const double value : space.inputs) inputs.push_back(LengthPolynomial::constant(variables_, value));
    for (int i = 0; i < variables_; ++i) {
      const auto replaced = substitution.find(i);
      inputs[static_cast<std::size_t>(space.free_inputs[static_cast<std::size_t>(i)])] =
          replaced == substitution.end() ? LengthPolynomial::variable(variables_, i) : replaced->second;
    }
    values_ = evaluate_polynomials(space.recording->graph, variables_, inputs);
    linkage_.balances_forces = requires_force_or_static_balance(space);
    linkage_.balances_moments = has_moments && requires_moment_balance(space);
    const Vector3 reference = find_moment_reference(space);
    linkage_.moment_reference = {reference[0], reference[1]};
  }

  PlanarLinkage read() {
    linkage_.variables = variables_;
    if (!linkage_.balances_forces && !linkage_.balances_moments)
      throw NotPolynomial("the conditions of moments are not included");
    uses_.assign(static_cast<std::size_t>(variables_), 0);
    if (counts_statics_alone(space_)) linkage_.gravity_direction = find_gravity_direction();
    read_directions();
    read_slides();
    linkage_.has_gears = !mechanism_.couplings.empty();
    if (linkage_.has_gears) read_couplings();
    read_tree();
    read_tool();
    read_bodies();
    if (linkage_.balances_moments) count_spin_uses();
    read_attachments();
    if (linkage_.balances_moments) read_spins();
    return std::move(linkage_);
  }

 private:
  LengthPolynomial polynomial(const Expression& x, const std::string& name) const {
    if (x.is_constant()) return LengthPolynomial::constant(variables_, x.value());
    const auto& value = values_[static_cast<std::size_t>(x.node())];
    if (!value) throw NotPolynomial(name + " is not a polynomial of the free numbers");
    return *value;
  }

  LengthPolynomial place(const Vector3Of<Expression>& position, const std::string& name) const {
    return polynomial(position[0], name) + polynomial(position[1], name) * imaginary_unit;
  }

  double constant(const Expression& x, const std::string& name) const {
    const auto value = x.is_constant() ? Coefficient(x.value()) : polynomial(x, name).constant_value();
    if (!value) throw NotPolynomial(name + " is free");
    return value->real();
  }

  void count_uses(const LengthPolynomial& p) {
    for (int i = 0; i < variables_; ++i)
      if (p.has_variable(i)) ++uses_[static_cast<std::size_t>(i)];
  }

  Coefficient find_gravity_direction() const {
    const Coefficient gravity(mechanism_.gravity[0].value(), mechanism_.gravity[1].value());
    return gravity / std::abs(gravity);
  }

  LengthPolynomial turned(int body, const LengthPolynomial& p) const {
    return p * linkage_.turns[static_cast<std::size_t>(body)];
  }
  int direction(int body) const { return linkage_.directions[static_cast<std::size_t>(body)]; }

  /// Bodies between prismatic and fixed joints share one.
  void read_directions() {
    const std::size_t bodies = mechanism_.bodies.size();
    linkage_.directions.assign(bodies, -1);
    linkage_.turns.assign(bodies, 1);
    for (std::size_t k = 0; k < bodies; ++k) {
      if (linkage_.directions[k] >= 0) continue;
      linkage_.directions[k] = static_cast<int>(linkage_.vectors.size());
      linkage_.vectors.push_back({mechanism_.bodies[k].name, -1});
      spread_direction();
    }
  }

  void spread_direction() {
    for (bool has_found = true; has_found;) {
      has_found = false;
      for (const auto& joint : mechanism_.joints) {
        if (lets_turn(joint.type)) continue;
        const auto first = static_cast<std::size_t>(joint.first), second = static_cast<std::size_t>(joint.second);
        const bool knows_first = linkage_.directions[first] >= 0, knows_second = linkage_.directions[second] >= 0;
        const Coefficient turn = rotation(joint);
        if (knows_first && knows_second) {
          if (std::abs(linkage_.turns[first] * turn - linkage_.turns[second]) > gear_tolerance)
            throw NotPolynomial("joint " + joint.name + " holds two bodies at an angle that their loop does not have");
          continue;
        }
        if (!knows_first && !knows_second) continue;
        const std::size_t from = knows_first ? first : second, to = knows_first ? second : first;
        linkage_.directions[to] = linkage_.directions[from];
        linkage_.turns[to] = linkage_.turns[from] * (knows_first ? turn : std::conj(turn));
        has_found = true;
      }
    }
  }

  Coefficient rotation(const model::JointOf<Expression>& joint) const {
    const std::string name = "the angle of joint " + joint.name;
    return {constant(joint.rotation(0, 0), name), constant(joint.rotation(1, 0), name)};
  }

  void read_slides() {
    for (const auto& joint : mechanism_.joints) {
      slides_.push_back(-1);
      axes_.push_back(0);
      if (!lets_slide(joint.type)) continue;
      const std::string name = "the axis of joint " + joint.name;
      const Coefficient axis(constant(joint.axis[0], name), constant(joint.axis[1], name));
      axes_.back() = axis / std::abs(axis) * linkage_.turns[static_cast<std::size_t>(joint.first)];
      slides_.back() = static_cast<int>(linkage_.vectors.size());
      linkage_.vectors.push_back({joint.name, direction(joint.first)});
    }
  }

  VectorSum slide(std::size_t joint, double sign) const {
    if (slides_[joint] < 0) return {};
    return {{slides_[joint], LengthPolynomial::constant(variables_, axes_[joint] * sign)}};
  }

  GearEquations list_gear_equations() const {
    const auto count = static_cast<Eigen::Index>(mechanism_.couplings.size());
    GearEquations equations{MatrixX::Zero(count, static_cast<Eigen::Index>(linkage_.vectors.size())),
                            MatrixX::Zero(count, static_cast<Eigen::Index>(mechanism_.joints.size())),
                            VectorX::Zero(count)};
    for (Eigen::Index row = 0; row < count; ++row) {
      const auto& coupling = mechanism_.couplings[static_cast<std::size_t>(row)];
      const std::string name =
          "the ratio of " + mechanism_.coordinates[static_cast<std::size_t>(coupling.follower)].name;
      const double ratio = constant(coupling.ratio, name);
      equations.right[row] = constant(coupling.offset, "the offset of a coupling");
      add_coordinate(coupling.follower, 1, row, equations);
      for (const auto& term : coupling.leader.terms)
        add_coordinate(term.coordinate, -ratio * constant(term.ratio, name), row, equations);
    }
    return equations;
  }

  /// factor · coordinate, as factor · (angle of second − angle of first − angle at zero).
  void add_coordinate(int coordinate, double factor, Eigen::Index row, GearEquations& equations) const {
    const Coordinate& moved = mechanism_.coordinates[static_cast<std::size_t>(coordinate)];
    const auto& joint = mechanism_.joints[static_cast<std::size_t>(moved.joint)];
    if (moved.kind == CoordinateKind::length) {
      equations.slides(row, static_cast<Eigen::Index>(moved.joint)) += factor;
      return;
    }
    if (joint.type == JointType::revolute && constant(joint.axis[2], "the axis of joint " + joint.name) < 0)
      factor = -factor;
    const Coefficient at_zero = rotation(joint) * linkage_.turns[static_cast<std::size_t>(joint.first)] *
                                std::conj(linkage_.turns[static_cast<std::size_t>(joint.second)]);
    equations.angles(row, direction(joint.second)) += factor;
    equations.angles(row, direction(joint.first)) -= factor;
    equations.right[row] += factor * std::arg(at_zero);
  }

  /// Directions that turn alike or against each other at all motions that the couplings allow, and slides that are
  /// proportional. With all other ratios the directions are independent functions.
  void read_couplings() {
    GearEquations equations = list_gear_equations();
    for (std::size_t k = 0; k < linkage_.vectors.size(); ++k)
      if (k == 0 || linkage_.vectors[k].slides_along >= 0) equations.angles.col(static_cast<Eigen::Index>(k)).setZero();
    relate_slides(equations);
    MatrixX all(equations.angles.rows(), equations.angles.cols() + equations.slides.cols());
    all << equations.angles, equations.slides;
    Eigen::FullPivLU<MatrixX> solver(all);
    solver.setThreshold(gear_tolerance);
    const VectorX constants = solver.solve(equations.right);
    const MatrixX motions = solver.kernel();
    std::vector<int> kept;
    std::map<int, int> replaced;
    std::map<int, Coefficient> factors;
    for (int k = 0; k < static_cast<int>(linkage_.vectors.size()); ++k) {
      if (linkage_.vectors[static_cast<std::size_t>(k)].slides_along >= 0) continue;
      const Eigen::RowVectorXd own = k == 0 ? Eigen::RowVectorXd::Zero(motions.cols()).eval() : motions.row(k).eval();
      const auto angle = [&](int vector) { return vector == 0 ? 0.0 : constants[vector]; };
      const auto row = [&](int vector) {
        return vector == 0 ? Eigen::RowVectorXd::Zero(motions.cols()).eval() : motions.row(vector).eval();
      };
      const auto alike = std::find_if(kept.begin(), kept.end(),
                                      [&](int other) { return numerics::max_abs(own - row(other)) < gear_tolerance; });
      if (alike != kept.end()) {
        replaced[k] = *alike;
        factors[k] = unit_vector(angle(k) - angle(*alike));
        continue;
      }
      const auto against = std::find_if(
          kept.begin(), kept.end(), [&](int other) { return numerics::max_abs(own + row(other)) < gear_tolerance; });
      if (against != kept.end() && linkage_.gravity_direction)
        linkage_.opposites[k] = {*against, unit_vector(angle(k) + angle(*against))};
      kept.push_back(k);
    }
    for (std::size_t body = 0; body < linkage_.directions.size(); ++body) {
      const auto found = replaced.find(linkage_.directions[body]);
      if (found == replaced.end()) continue;
      linkage_.turns[body] *= factors[found->first];
      linkage_.directions[body] = found->second;
    }
    for (std::size_t j = 0; j < slides_.size(); ++j) {
      if (slides_[j] < 0) continue;
      int& along = linkage_.vectors[static_cast<std::size_t>(slides_[j])].slides_along;
      const auto found = replaced.find(along);
      if (found == replaced.end()) continue;
      axes_[j] *= factors[found->first];
      along = found->second;
    }
  }

  /// What the couplings require of slides alone, where they slide along the same direction.
  void relate_slides(const GearEquations& equations) {
    Eigen::FullPivLU<MatrixX> solver(equations.angles.transpose());
    solver.setThreshold(gear_tolerance);
    MatrixX combinations = solver.kernel();
    if (solver.dimensionOfKernel() == 0) return;
    for (Eigen::Index c = 0; c < combinations.cols(); ++c) {
      const VectorX slides = equations.slides.transpose() * combinations.col(c);
      if (numerics::max_abs(slides) < gear_tolerance) continue;
      // the closures would have to be combined first: only one relation at a time is recognised
      if (combinations.cols() > 1) throw NotPolynomial("several couplings relate its slides");
      LoopClosure closure;
      int along = -1;
      for (std::size_t j = 0; j < slides_.size(); ++j) {
        const double factor = slides[static_cast<Eigen::Index>(j)];
        if (std::abs(factor) < gear_tolerance) continue;
        const int own = linkage_.vectors[static_cast<std::size_t>(slides_[j])].slides_along;
        if (along >= 0 && own != along) return;  // functions of different directions are independent
        along = own;
        closure.links[slides_[j]] = LengthPolynomial::constant(variables_, factor);
      }
      const double offset = equations.right.dot(combinations.col(c));
      if (along == 0)
        closure.ground = LengthPolynomial::constant(variables_, -offset);
      else if (offset != 0)
        closure.links[along] = LengthPolynomial::constant(variables_, -offset);
      linkage_.closures.push_back(std::move(closure));
    }
  }

  /// Position of a point of a body in the tree.
  VectorSum locate(int body, const LengthPolynomial& point) const {
    const VectorSum sum = linkage_.tree_joints[static_cast<std::size_t>(body)];
    return sum + VectorSum{{direction(body), turned(body, point - references_[static_cast<std::size_t>(body)])}};
  }

  void read_tree() {
    const std::size_t bodies = mechanism_.bodies.size(), joints = mechanism_.joints.size();
    linkage_.tree_joints.resize(bodies);
    linkage_.joint_places.resize(linkage_.vectors.size());
    references_.resize(bodies);
    std::vector<bool> is_placed(bodies, false), is_used(joints, false);
    is_placed[0] = true;
    std::vector<std::array<LengthPolynomial, 2>> points;
    for (const auto& joint : mechanism_.joints) {
      points.push_back({place(joint.point_first, "a point of joint " + joint.name),
                        place(joint.point_second, "a point of joint " + joint.name)});
      if (lets_turn(joint.type)) linkage_.joints.push_back({direction(joint.first), direction(joint.second)});
      if (joint.first != model::ground) count_uses(points.back()[0]);
      if (joint.second != model::ground) count_uses(points.back()[1]);
    }
    const auto end = [&](std::size_t joint, std::size_t side) {
      return static_cast<int>(side == 0 ? mechanism_.joints[joint].first : mechanism_.joints[joint].second);
    };
    for (std::vector<int> level{0}; !level.empty();) {
      std::vector<int> next;
      for (std::size_t j = 0; j < joints; ++j)
        for (std::size_t side = 0; side < 2 && !is_used[j]; ++side) {
          const int parent = end(j, side), child = end(j, 1 - side);
          if (is_placed[static_cast<std::size_t>(child)] ||
              std::find(level.begin(), level.end(), parent) == level.end())
            continue;
          // the second body's point is ahead of the first's by the slide
          linkage_.tree_joints[static_cast<std::size_t>(child)] =
              locate(parent, points[j][side]) + slide(j, side == 0 ? 1 : -1);
          references_[static_cast<std::size_t>(child)] = points[j][1 - side];
          is_placed[static_cast<std::size_t>(child)] = is_used[j] = true;
          next.push_back(child);
        }
      level = std::move(next);
    }
    if (std::find(is_placed.begin(), is_placed.end(), false) != is_placed.end())
      throw NotPolynomial("some bodies are not connected with the ground");
    for (std::size_t j = 0; j < joints; ++j) {
      for (std::size_t side = 0; side < 2; ++side) add_joint_place(end(j, side), points[j][side]);
      if (!is_used[j]) close_loop(j, points[j]);
    }
    separate_parts();
  }

  void add_joint_place(int body, const LengthPolynomial& point) {
    const LengthPolynomial offset = turned(body, point - references_[static_cast<std::size_t>(body)]);
    if (direction(body) != 0 && !offset.is_zero())
      linkage_.joint_places[static_cast<std::size_t>(direction(body))].push_back(offset);
  }

  void close_loop(std::size_t joint, const std::array<LengthPolynomial, 2>& points) {
    VectorSum sum = slide(joint, 1);
    for (std::size_t side = 0; side < 2; ++side) {
      const int body = side == 0 ? mechanism_.joints[joint].first : mechanism_.joints[joint].second;
      sum = sum + locate(body, points[side]) * LengthPolynomial::constant(variables_, side == 0 ? 1 : -1);
    }
    linkage_.closures.push_back(make_closure(std::move(sum)));
    ++linkage_.loops;
  }

  static LoopClosure make_closure(VectorSum sum) {
    LoopClosure closure;
    if (const auto constant = sum.find(0); constant != sum.end()) {
      closure.ground = constant->second;
      sum.erase(constant);
    }
    for (auto link = sum.begin(); link != sum.end();) link = link->second.is_zero() ? sum.erase(link) : std::next(link);
    closure.links = std::move(sum);
    return closure;
  }

  int slides_along(int vector) const { return linkage_.vectors[static_cast<std::size_t>(vector)].slides_along; }

  /// The closures' real and imaginary parts where both hold for the same vectors.
  void separate_parts() {
    std::vector<LoopClosure>& closures = linkage_.closures;
    for (std::size_t i = 0; i < closures.size(); ++i)
      for (std::size_t j = i + 1; j < closures.size(); ++j) eliminate_turning(closures[i], closures[j]);
    std::vector<LoopClosure> separated;
    for (LoopClosure& closure : closures) separate(std::move(closure), separated);
    closures = std::move(separated);
  }

  /// Replaces the second closure by its combination with the first if all but slides of the ground cancel.
  void eliminate_turning(const LoopClosure& first, LoopClosure& second) {
    const auto turns = [&](const auto& link) { return slides_along(link.first) != 0; };
    const auto pivot = std::find_if(first.links.begin(), first.links.end(), turns);
    if (pivot == first.links.end()) return;
    const auto other = second.links.find(pivot->first);
    if (other == second.links.end() || std::count_if(first.links.begin(), first.links.end(), turns) !=
                                           std::count_if(second.links.begin(), second.links.end(), turns))
      return;
    LengthPolynomial factor_first = other->second, factor_second = pivot->second;
    if (const auto quotient = other->second.divide(pivot->second)) {
      factor_first = *quotient;
      factor_second = LengthPolynomial::constant(variables_, 1);
    }
    const VectorSum a = first.links * factor_first, b = second.links * factor_second;
    VectorSum rest;
    for (const auto& [vector, coefficient] : b) {
      const auto found = a.find(vector);
      const LengthPolynomial difference = found == a.end() ? coefficient : coefficient - found->second;
      if (slides_along(vector) == 0)
        rest[vector] = difference;
      else if (!cancels(difference, coefficient))
        return;
    }
    for (const auto& [vector, coefficient] : a)
      if (b.count(vector) == 0) rest[vector] = -coefficient;
    rest[0] = second.ground * factor_second - first.ground * factor_first;
    if (!factor_second.constant_value()) linkage_.divisors.push_back(factor_second);
    second = make_closure(std::move(rest));
  }

  static bool cancels(const LengthPolynomial& difference, const LengthPolynomial& term) {
    double largest = 0;
    for (const auto& [exponents, coefficient] : term.terms()) largest = std::max(largest, std::abs(coefficient));
    return std::all_of(difference.terms().begin(), difference.terms().end(),
                       [&](const auto& one) { return std::abs(one.second) <= cancellation_tolerance * largest; });
  }

  void separate(LoopClosure closure, std::vector<LoopClosure>& closures) const {
    std::optional<int> along;  // the only direction
    for (const auto& [vector, coefficient] : closure.links) {
      (void)coefficient;
      const int own = slides_along(vector) >= 0 ? slides_along(vector) : vector;
      if (along && *along != own) along = -1;
      if (!along) along = own;
    }
    if (!along || *along < 0 || (*along > 0 && !closure.ground.is_zero())) {
      closures.push_back(std::move(closure));
      return;
    }
    // the last slide is in the real part alone
    const auto form = find_polar_form(closure.links.rbegin()->second);
    const Coefficient unit = form ? form->unit : Coefficient(1);
    for (const Coefficient part : {Coefficient(1), -imaginary_unit}) {
      LoopClosure separated;
      const auto take = [&](const LengthPolynomial& p) {
        const LengthPolynomial taken = (p * (std::conj(unit) * part)).real();
        return cancels(taken, p) ? LengthPolynomial() : taken;
      };
      for (const auto& [vector, coefficient] : closure.links)
        if (const LengthPolynomial taken = take(coefficient); !taken.is_zero()) separated.links[vector] = taken;
      separated.ground = take(closure.ground);
      if (!separated.links.empty()) closures.push_back(std::move(separated));
    }
  }

  void read_tool() {
    if (!mechanism_.tool || mechanism_.tool->body == model::ground) return;
    const int body = mechanism_.tool->body;
    linkage_.tool = make_closure(locate(body, place(mechanism_.tool->position, "the tool's place")));
  }

  void read_bodies() {
    for (std::size_t k = 1; k < mechanism_.bodies.size(); ++k) {
      const auto& body = mechanism_.bodies[k];
      CarriedMass carried{static_cast<int>(k), place(body.com, body.name + "'s centre of mass"),
                          polynomial(body.mass, body.name + "'s mass")};
      count_uses(carried.place);
      count_uses(carried.mass);
      add_mass(std::move(carried), false);
    }
  }

  void add_mass(CarriedMass carried, bool is_counterweight) {
    carried.place = turned(carried.body, carried.place - references_[static_cast<std::size_t>(carried.body)]);
    if (is_counterweight || counts_total_mass()) linkage_.fixed_size += carried.mass;
    linkage_.masses.push_back(std::move(carried));
  }

  bool counts_total_mass() const {
    return space_.start.design.minimize.front().size == ObjectiveTerm::Size::total_mass;
  }

  static const Expression& inertia(const Matrix3Of<Expression>& matrix) { return matrix(2, 2); }

  LengthPolynomial inertia_of(const Matrix3Of<Expression>& matrix, const std::string& name) const {
    return polynomial(inertia(matrix), name + "'s inertia");
  }

  void count_spin_uses() {
    if (linkage_.has_gears) throw NotPolynomial("moments of gears are not included");
    for (std::size_t k = 1; k < mechanism_.bodies.size(); ++k)
      count_uses(inertia_of(mechanism_.bodies[k].inertia, mechanism_.bodies[k].name));
    for (const auto& attachment : mechanism_.attachments) count_uses(inertia_of(attachment.inertia, attachment.name));
    for (const auto& disc : mechanism_.discs) {
      count_uses(inertia_of(disc.inertia, disc.name));
      count_uses(polynomial(disc.ratio, disc.name + "'s ratio"));
      for (const auto& term : disc.follows.terms) count_uses(polynomial(term.ratio, disc.name + "'s ratio"));
    }
  }

  VectorSum spin_of(int body, const LengthPolynomial& factor) const {
    if (direction(body) == 0) return {};
    return {{direction(body), factor}};
  }

  /// Rate of a revolute joint's coordinate.
  VectorSum rate_of(CoordinateId coordinate, const LengthPolynomial& factor) const {
    const Coordinate& moved = mechanism_.coordinates[static_cast<std::size_t>(coordinate)];
    const auto& joint = mechanism_.joints[static_cast<std::size_t>(moved.joint)];
    if (moved.kind == CoordinateKind::length) throw NotPolynomial("a disc follows a slide");
    const bool is_reversed =
        joint.type == JointType::revolute && constant(joint.axis[2], "the axis of joint " + joint.name) < 0;
    const LengthPolynomial forward = is_reversed ? -factor : factor;
    return spin_of(joint.second, forward) + spin_of(joint.first, -forward);
  }

  /// Angular velocity of a disc.
  RatioSpin spin_of(const model::DiscOf<Expression>& disc) {
    const double axis = constant(disc.axis[2], disc.name + "'s axis");
    VectorSum follower;
    for (const auto& term : disc.follows.terms)
      follower = follower + rate_of(term.coordinate,
                                    polynomial(term.ratio, disc.name + "'s ratio") * Coefficient(axis < 0 ? -1 : 1));
    const LengthPolynomial one = LengthPolynomial::constant(variables_, 1);
    const LengthPolynomial ratio = polynomial(disc.ratio, disc.name + "'s ratio");
    RatioSpin spin{spin_of(disc.body, one), {}, own_number(ratio)};
    if (spin.ratio_number >= 0)
      spin.per_ratio = follower;
    else
      spin.constant = spin.constant + follower * ratio;
    return spin;
  }

  static RatioSpin scaled(const RatioSpin& spin, const LengthPolynomial& factor) {
    return {spin.constant * factor, spin.per_ratio * factor, spin.ratio_number};
  }

  void read_spins() {
    const LengthPolynomial one = LengthPolynomial::constant(variables_, 1);
    for (std::size_t k = 1; k < mechanism_.bodies.size(); ++k) {
      const auto& body = mechanism_.bodies[k];
      add_spin(body.name, inertia_of(body.inertia, body.name), {spin_of(static_cast<int>(k), one), {}, -1}, nullptr);
    }
    for (std::size_t a = 0; a < mechanism_.attachments.size(); ++a) {
      const auto& attachment = mechanism_.attachments[a];
      add_spin(attachment.name, inertia_of(attachment.inertia, attachment.name),
               {spin_of(attachment.body, one), {}, -1}, find_counterweight(static_cast<int>(a), -1));
    }
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d) {
      const auto& disc = mechanism_.discs[d];
      add_spin(disc.name, inertia_of(disc.inertia, disc.name), spin_of(disc),
               find_counterweight(-1, static_cast<int>(d)), static_cast<int>(d));
    }
  }

  FreeCounterweight* find_counterweight(int attachment, int disc) {
    const auto found =
        std::find_if(linkage_.counterweights.begin(), linkage_.counterweights.end(),
                     [&](const FreeCounterweight& one) { return one.attachment == attachment && one.disc == disc; });
    return found == linkage_.counterweights.end() ? nullptr : &*found;
  }

  /// @param spin angular velocity
  /// @param counterweight whose inertia it is; null: another's
  void add_spin(const std::string& name, const LengthPolynomial& inertia, const RatioSpin& spin,
                FreeCounterweight* counterweight, int disc = -1) {
    if (spin.constant.empty() && spin.per_ratio.empty()) return;
    if (counterweight != nullptr && counterweight->mass_number >= 0 &&
        inertia.has_variable(counterweight->mass_number)) {
      const auto per_mass = inertia.divide(LengthPolynomial::variable(variables_, counterweight->mass_number));
      if (!per_mass || per_mass->has_variable(counterweight->mass_number))
        throw NotPolynomial("the inertia of " + name + " is not in proportion to its mass");
      counterweight->spin = scaled(spin, *per_mass);
      return;
    }
    FreeInertia added;
    added.name = name;
    added.disc = disc;
    added.number = own_number(inertia);
    if (added.number < 0 && spin.ratio_number < 0) {
      linkage_.fixed_spin = linkage_.fixed_spin + spin.constant * inertia;
      return;
    }
    added.spin = added.number < 0 ? scaled(spin, inertia) : spin;
    // an element that may be left out has none then
    const bool may_vanish = !space_.start.design.cardinality.empty();
    added.lower = added.number < 0 ? 1 : may_vanish ? 0 : free_number(added.number).lower;
    added.upper = added.number < 0 ? 1 : free_number(added.number).upper;
    if (!(added.lower >= 0)) throw NotPolynomial("the inertia of " + name + " may be negative");
    linkage_.inertias.push_back(std::move(added));
  }

  /// A counterweight, payload or disc.
  struct PointMass {
    LengthPolynomial mass;
    std::array<LengthPolynomial, 2> place;
    LengthPolynomial inertia;  ///< zero if moments do not count
  };

  template <class Carried>
  PointMass read_point_mass(const Carried& carried) {
    PointMass read{polynomial(carried.mass, carried.name + "'s mass"),
                   {polynomial(carried.position[0], carried.name + "'s place"),
                    polynomial(carried.position[1], carried.name + "'s place")},
                   linkage_.balances_moments ? inertia_of(carried.inertia, carried.name) : LengthPolynomial()};
    count_uses(read.mass);
    for (const auto& coordinate : read.place) count_uses(coordinate);
    return read;
  }

  void read_attachments() {
    std::vector<PointMass> attachments, discs;
    for (const auto& attachment : mechanism_.attachments) attachments.push_back(read_point_mass(attachment));
    for (const auto& disc : mechanism_.discs) discs.push_back(read_point_mass(disc));
    for (std::size_t a = 0; a < attachments.size(); ++a) {
      const auto& attachment = mechanism_.attachments[a];
      FreeCounterweight added;
      added.attachment = static_cast<int>(a);
      added.name = attachment.name;
      added.body = attachment.body;
      add_point_mass(std::move(added), attachments[a], attachment.kind == AttachmentKind::counterweight);
    }
    for (std::size_t d = 0; d < discs.size(); ++d) {
      FreeCounterweight added;
      added.disc = static_cast<int>(d);
      added.name = mechanism_.discs[d].name;
      added.body = mechanism_.discs[d].body;
      add_point_mass(std::move(added), discs[d], true);
    }
  }

  /// The free number that a polynomial is, if nothing else depends on it.
  int own_number(const LengthPolynomial& p) const {
    const int number = find_plain_variable(p);
    return number >= 0 && uses_[static_cast<std::size_t>(number)] == 1 ? number : -1;
  }

  /// The free number that is its mass, if nothing else depends on it but its inertia.
  int own_mass(const PointMass& read) const {
    const int number = find_plain_variable(read.mass);
    if (number < 0 || !read.inertia.has_variable(number)) return own_number(read.mass);
    return uses_[static_cast<std::size_t>(number)] == 2 ? number : -1;
  }

  /// One with sizes is bounded like a length.
  int own_coordinate(const LengthPolynomial& p) {
    const int number = own_number(p);
    if (number < 0 || free_number(number).discrete_values.empty()) return number;
    linkage_.sized_places.push_back(number);
    return -1;
  }

  const FreeNumber& free_number(int index) const { return space_.start.free_numbers[static_cast<std::size_t>(index)]; }

  void add_point_mass(FreeCounterweight counterweight, const PointMass& read, bool is_counterweight) {
    const LengthPolynomial& mass = read.mass;
    const auto& place = read.place;
    if (counterweight.body == model::ground && counterweight.disc < 0) return;
    const int mass_number = own_mass(read);
    const std::array<int, 2> place_numbers{own_coordinate(place[0]), own_coordinate(place[1])};
    const auto constant_mass = mass.constant_value();
    if (mass_number < 0 && (!constant_mass || (place_numbers[0] < 0 && place_numbers[1] < 0))) {
      add_mass({counterweight.body, place[0] + place[1] * imaginary_unit, mass}, is_counterweight);
      return;
    }
    if (!is_counterweight && !counts_total_mass())
      throw NotPolynomial(counterweight.name + " is free but does not count as added mass");
    counterweight.mass_number = mass_number;
    counterweight.lower = mass_number < 0 ? constant_mass->real() : free_number(mass_number).lower;
    counterweight.upper = mass_number < 0 ? constant_mass->real() : free_number(mass_number).upper;
    if (!(counterweight.lower >= 0)) throw NotPolynomial(counterweight.name + " may have a negative mass");
    counterweight.place_numbers = place_numbers;
    std::array<std::vector<LengthPolynomial>, 2> ends;
    for (std::size_t i = 0; i < 2; ++i) {
      const int number = place_numbers[i];
      if (number < 0)
        ends[i] = {place[i]};
      else
        for (const double end : {free_number(number).lower, free_number(number).upper})
          ends[i].push_back(LengthPolynomial::constant(variables_, end));
    }
    const LengthPolynomial zero, x0 = place_numbers[0] < 0 ? place[0] : zero,
                                 y0 = place_numbers[1] < 0 ? place[1] : zero;
    counterweight.origin = turned(counterweight.body,
                                  x0 + y0 * imaginary_unit - references_[static_cast<std::size_t>(counterweight.body)]);
    for (const auto& x : ends[0])
      for (const auto& y : ends[1])
        counterweight.corners.push_back(turned(
            counterweight.body, x + y * imaginary_unit - references_[static_cast<std::size_t>(counterweight.body)]));
    linkage_.counterweights.push_back(std::move(counterweight));
  }

  const DesignSpace& space_;
  const MechanismOf<Expression>& mechanism_;
  int variables_;
  std::vector<std::optional<LengthPolynomial>> values_;
  std::vector<int> uses_;                     ///< per free number: how many quantities depend on it
  std::vector<LengthPolynomial> references_;  ///< per body: its tree joint in its axes
  std::vector<int> slides_;                   ///< per joint: its slide's vector; −1: none
  std::vector<Coefficient> axes_;             ///< per joint: of its slide, divided by the direction vector
  PlanarLinkage linkage_;
};

}  // namespace

VectorSum operator+(VectorSum a, const VectorSum& b) {
  for (const auto& [vector, coefficient] : b) a[vector] += coefficient;
  return a;
}

VectorSum operator*(const VectorSum& sum, const LengthPolynomial& factor) {
  VectorSum product;
  for (const auto& [vector, coefficient] : sum) product[vector] = coefficient * factor;
  return product;
}

std::vector<int> list_free_ratios(const PlanarLinkage& linkage) {
  std::vector<int> numbers;
  const auto add = [&](const RatioSpin& spin) {
    if (spin.ratio_number >= 0) numbers.push_back(spin.ratio_number);
  };
  for (const FreeCounterweight& counterweight : linkage.counterweights) add(counterweight.spin);
  for (const FreeInertia& inertia : linkage.inertias) add(inertia.spin);
  return numbers;
}

bool has_free_lengths(const PlanarLinkage& linkage) {
  const auto varies = [&](const LengthPolynomial& p) {
    for (int number = 0; number < linkage.variables; ++number)
      if (p.has_variable(number) &&
          std::find(linkage.sized_places.begin(), linkage.sized_places.end(), number) == linkage.sized_places.end())
        return true;
    return false;
  };
  for (const LoopClosure& closure : linkage.closures)
    for (const auto& [body, coefficient] : closure.links)
      if (varies(coefficient)) return true;
  for (const CarriedMass& carried : linkage.masses)
    if (varies(carried.place) || varies(carried.mass)) return true;
  for (const VectorSum& position : linkage.tree_joints)
    for (const auto& [vector, coefficient] : position)
      if (vector != 0 && varies(coefficient)) return true;
  return std::any_of(linkage.counterweights.begin(), linkage.counterweights.end(),
                     [&](const FreeCounterweight& counterweight) {
                       return std::any_of(counterweight.corners.begin(), counterweight.corners.end(), varies);
                     });
}

bool requires_moment_balance(const DesignSpace& space) {
  return has_goal(space, study::requires_zero_angular_momentum);
}

Vector3 find_moment_reference(const DesignSpace& space) {
  return space.start.trajectories.empty() ? Vector3::Zero().eval() : space.start.trajectories.front().about;
}

bool requires_force_or_static_balance(const DesignSpace& space) {
  return has_goal(
      space, [](const Goal& goal) { return study::requires_zero_momentum(goal) || goal.kind == GoalKind::statics; });
}

LengthBox list_number_bounds(const DesignSpace& space) {
  const auto count = static_cast<Eigen::Index>(space.start.free_numbers.size());
  LengthBox box{VectorX(count), VectorX(count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    box.lower[i] = space.start.free_numbers[static_cast<std::size_t>(i)].lower;
    box.upper[i] = space.start.free_numbers[static_cast<std::size_t>(i)].upper;
  }
  return box;
}

LinkageReading read_linkage(const DesignSpace& space, const LengthSubstitution& substitution, bool has_moments) {
  try {
    if (!space.recording) return {{}, "the mechanism has no free numbers"};
    check_request(space);
    return {LinkageReader(space, substitution, has_moments).read(), {}};
  } catch (const NotPolynomial& reason) {
    return {{}, reason.what()};
  }
}

}  // namespace balance::certificate
