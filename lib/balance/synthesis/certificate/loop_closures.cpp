#include "balance/synthesis/certificate/loop_closures.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::certificate {
namespace {

/// Ends the reading with a reason.
struct NotPolynomial : std::runtime_error {
  using std::runtime_error::runtime_error;
};

bool requires_force_balance(const Goal& goal) { return goal.kind == GoalKind::force || goal.kind == GoalKind::dynamic; }

/// Static efforts vanish in the same mechanisms as shaking forces if all coordinates are actuated, there is gravity and
/// nothing else but masses asks for efforts.
void check_statics(const MechanismOf<Expression>& mechanism) {
  const auto is_zero = [](const Expression& g) { return g.is_constant() && g.value() == 0; };
  if (is_zero(mechanism.gravity[0]) && is_zero(mechanism.gravity[1])) throw NotPolynomial("there is no gravity");
  for (int i = 0; i < 3; ++i)
    if (!mechanism.gravity[i].is_constant()) throw NotPolynomial("gravity is not constant");
  if (!mechanism.springs.empty()) throw NotPolynomial("springs carry a part of the weight");
  if (!mechanism.loads.empty()) throw NotPolynomial("loads act on it");
  if (!mechanism.friction.empty()) throw NotPolynomial("joints have friction");
}

void check_request(const DesignSpace& space) {
  const DesignRequest& request = space.start.design;
  const MechanismOf<Expression>& mechanism = space.recording->mechanism;
  if (mechanism.space != SpaceKind::planar) throw NotPolynomial("the mechanism is not planar");
  const bool is_force = std::any_of(request.goals.begin(), request.goals.end(), requires_force_balance);
  const bool is_static = std::any_of(request.goals.begin(), request.goals.end(),
                                     [](const Goal& goal) { return goal.kind == GoalKind::statics; });
  if (!is_force && !is_static) throw NotPolynomial("the goals require neither balanced forces nor balanced statics");
  if (!is_force) check_statics(mechanism);
  if (request.minimize.size() != 1 || request.front ||
      (request.minimize[0].size != ObjectiveTerm::Size::added_mass &&
       request.minimize[0].size != ObjectiveTerm::Size::total_mass) ||
      request.minimize[0].weight != 1)
    throw NotPolynomial("the objective is neither the added mass nor the total mass");
  if (request.cases.size() > 1 || !request.cases.numbers.empty()) throw NotPolynomial("there are several load cases");
  if (!mechanism.discs.empty()) throw NotPolynomial("it has discs");
  if (!mechanism.couplings.empty()) throw NotPolynomial("gears or belts couple its joints");
  if (!mechanism.constraints.empty()) throw NotPolynomial("its speeds are constrained");
  for (const auto& joint : mechanism.joints)
    if (joint.type != JointType::revolute) throw NotPolynomial("joint " + joint.name + " is not revolute");
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

class LinkageReader {
 public:
  LinkageReader(const DesignSpace& space, const LengthSubstitution& substitution)
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
  }

  PlanarLinkage read() {
    linkage_.variables = variables_;
    uses_.assign(static_cast<std::size_t>(variables_), 0);
    for (const auto& body : mechanism_.bodies) linkage_.body_names.push_back(body.name);
    read_tree();
    read_tool();
    read_bodies();
    read_attachments();
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

  void count_uses(const LengthPolynomial& p) {
    for (int i = 0; i < variables_; ++i)
      if (p.has_variable(i)) ++uses_[static_cast<std::size_t>(i)];
  }

  /// Position of a point of a body in the tree.
  BodySum locate(int body, const LengthPolynomial& point) const {
    BodySum sum = linkage_.tree_joints[static_cast<std::size_t>(body)];
    return sum + BodySum{{body, point - references_[static_cast<std::size_t>(body)]}};
  }

  void read_tree() {
    const std::size_t bodies = mechanism_.bodies.size(), joints = mechanism_.joints.size();
    linkage_.tree_joints.resize(bodies);
    linkage_.joint_places.resize(bodies);
    references_.resize(bodies);
    origins_.resize(bodies);
    std::vector<bool> is_placed(bodies, false), is_used(joints, false);
    is_placed[0] = true;
    std::vector<std::array<LengthPolynomial, 2>> points;
    for (const auto& joint : mechanism_.joints) {
      points.push_back({place(joint.point_first, "a point of joint " + joint.name),
                        place(joint.point_second, "a point of joint " + joint.name)});
      linkage_.joints.push_back({joint.first, joint.second});
      if (joint.first != ground) count_uses(points.back()[0]);
      if (joint.second != ground) count_uses(points.back()[1]);
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
          if (parent != ground) linkage_.tree_joints[static_cast<std::size_t>(child)] = locate(parent, points[j][side]);
          origins_[static_cast<std::size_t>(child)] =
              parent == ground ? points[j][side] : origins_[static_cast<std::size_t>(parent)];
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
  }

  void add_joint_place(int body, const LengthPolynomial& point) {
    LengthPolynomial offset = point - references_[static_cast<std::size_t>(body)];
    if (body != ground && !offset.is_zero()) linkage_.joint_places[static_cast<std::size_t>(body)].push_back(offset);
  }

  void close_loop(std::size_t joint, const std::array<LengthPolynomial, 2>& points) {
    LoopClosure closure;
    for (std::size_t side = 0; side < 2; ++side) {
      const int body = side == 0 ? mechanism_.joints[joint].first : mechanism_.joints[joint].second;
      const LengthPolynomial sign = LengthPolynomial::constant(variables_, side == 0 ? 1 : -1);
      if (body != ground) closure.links = closure.links + locate(body, points[side]) * sign;
      closure.ground += (body == ground ? points[side] : origins_[static_cast<std::size_t>(body)]) * sign;
    }
    for (auto link = closure.links.begin(); link != closure.links.end();)
      link = link->second.is_zero() ? closure.links.erase(link) : std::next(link);
    linkage_.closures.push_back(std::move(closure));
  }

  void read_tool() {
    if (!mechanism_.tool || mechanism_.tool->body == ground) return;
    const int body = mechanism_.tool->body;
    linkage_.tool = LoopClosure{locate(body, place(mechanism_.tool->position, "the tool's place")),
                                origins_[static_cast<std::size_t>(body)]};
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
    carried.place = carried.place - references_[static_cast<std::size_t>(carried.body)];
    if (is_counterweight || counts_total_mass()) linkage_.fixed_size += carried.mass;
    linkage_.masses.push_back(std::move(carried));
  }

  bool counts_total_mass() const {
    return space_.start.design.minimize.front().size == ObjectiveTerm::Size::total_mass;
  }

  void read_attachments() {
    struct Coordinates {
      LengthPolynomial mass;
      std::array<LengthPolynomial, 2> place;
    };
    std::vector<Coordinates> all;
    for (const auto& attachment : mechanism_.attachments) {
      all.push_back({polynomial(attachment.mass, attachment.name + "'s mass"),
                     {polynomial(attachment.position[0], attachment.name + "'s place"),
                      polynomial(attachment.position[1], attachment.name + "'s place")}});
      count_uses(all.back().mass);
      for (const auto& coordinate : all.back().place) count_uses(coordinate);
    }
    for (std::size_t a = 0; a < all.size(); ++a) add_attachment(static_cast<int>(a), all[a].mass, all[a].place);
  }

  /// The free number that a polynomial is, if nothing else depends on it.
  int own_number(const LengthPolynomial& p) const {
    const int number = find_plain_variable(p);
    return number >= 0 && uses_[static_cast<std::size_t>(number)] == 1 ? number : -1;
  }

  /// One with sizes is bounded like a length.
  int own_coordinate(const LengthPolynomial& p) {
    const int number = own_number(p);
    if (number < 0 || free_number(number).discrete_values.empty()) return number;
    linkage_.sized_places.push_back(number);
    return -1;
  }

  const FreeNumber& free_number(int index) const { return space_.start.free_numbers[static_cast<std::size_t>(index)]; }

  void add_attachment(int index, const LengthPolynomial& mass, const std::array<LengthPolynomial, 2>& place) {
    const auto& attachment = mechanism_.attachments[static_cast<std::size_t>(index)];
    const bool is_counterweight = attachment.kind == AttachmentKind::counterweight;
    if (attachment.body == ground) return;
    const int mass_number = own_number(mass);
    const std::array<int, 2> place_numbers{own_coordinate(place[0]), own_coordinate(place[1])};
    const auto constant_mass = mass.constant_value();
    if (mass_number < 0 && (!constant_mass || (place_numbers[0] < 0 && place_numbers[1] < 0))) {
      add_mass({attachment.body, place[0] + place[1] * imaginary_unit, mass}, is_counterweight);
      return;
    }
    if (!is_counterweight && !counts_total_mass())
      throw NotPolynomial(attachment.name + " is free but does not count as added mass");
    FreeCounterweight counterweight;
    counterweight.attachment = index;
    counterweight.name = attachment.name;
    counterweight.body = attachment.body;
    counterweight.mass_number = mass_number;
    counterweight.lower = mass_number < 0 ? constant_mass->real() : free_number(mass_number).lower;
    counterweight.upper = mass_number < 0 ? constant_mass->real() : free_number(mass_number).upper;
    if (!(counterweight.lower >= 0)) throw NotPolynomial(attachment.name + " may have a negative mass");
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
    for (const auto& x : ends[0])
      for (const auto& y : ends[1])
        counterweight.corners.push_back(x + y * imaginary_unit -
                                        references_[static_cast<std::size_t>(counterweight.body)]);
    linkage_.counterweights.push_back(std::move(counterweight));
  }

  const DesignSpace& space_;
  const MechanismOf<Expression>& mechanism_;
  int variables_;
  std::vector<std::optional<LengthPolynomial>> values_;
  std::vector<int> uses_;                     ///< per free number: how many quantities depend on it
  std::vector<LengthPolynomial> references_;  ///< per body: its tree joint in its axes
  std::vector<LengthPolynomial> origins_;     ///< per body: the ground's point where its branch of the tree begins
  PlanarLinkage linkage_;
};

}  // namespace

BodySum operator+(BodySum a, const BodySum& b) {
  for (const auto& [body, coefficient] : b) a[body] += coefficient;
  return a;
}

BodySum operator*(const BodySum& sum, const LengthPolynomial& factor) {
  BodySum product;
  for (const auto& [body, coefficient] : sum) product[body] = coefficient * factor;
  return product;
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
  for (const BodySum& position : linkage.tree_joints)
    for (const auto& [body, coefficient] : position)
      if (varies(coefficient)) return true;
  return std::any_of(linkage.counterweights.begin(), linkage.counterweights.end(),
                     [&](const FreeCounterweight& counterweight) {
                       return std::any_of(counterweight.corners.begin(), counterweight.corners.end(), varies);
                     });
}

LinkageReading read_linkage(const DesignSpace& space, const LengthSubstitution& substitution) {
  try {
    if (!space.recording) return {{}, "the mechanism has no free numbers"};
    check_request(space);
    return {LinkageReader(space, substitution).read(), {}};
  } catch (const NotPolynomial& reason) {
    return {{}, reason.what()};
  }
}

}  // namespace balance::certificate
