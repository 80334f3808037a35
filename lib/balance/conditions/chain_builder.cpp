#include "balance/conditions/chain_builder.hpp"

#include "balance/conditions/cuts.hpp"
#include "balance/conditions/known_terms.hpp"

namespace balance {

using Eigen::Index;

VectorX point_mass_parameters(SpaceKind space, const Vector3& r) {
  if (space == SpaceKind::planar) return Eigen::Vector4d(1, r.x(), r.y(), r.head<2>().squaredNorm());
  VectorX pi(10);
  pi << 1, r, r.y() * r.y() + r.z() * r.z(), r.x() * r.x() + r.z() * r.z(), r.x() * r.x() + r.y() * r.y(),
      -r.x() * r.y(), -r.x() * r.z(), -r.y() * r.z();
  return pi;
}

ParameterColumns::ParameterColumns(const std::vector<Parameter>& parameters)
    : count_(static_cast<Index>(parameters.size())) {
  for (Index p = 0; p < count_; ++p) {
    const Parameter& parameter = parameters[static_cast<std::size_t>(p)];
    ++ranges_.try_emplace({parameter.owner_kind, parameter.index}, p, 0).first->second.second;
  }
}

ChainBuilder::ChainBuilder(const Mechanism& whole, const FreeSprings& loose, const ParameterColumns& columns)
    : whole_(whole),
      loose_(loose),
      columns_(columns),
      body_(whole.bodies.size(), -1),
      coordinate_(whole.coordinates.size(), -1) {
  chain_.mechanism.name = whole.name;
  chain_.mechanism.space = whole.space;
  chain_.mechanism.gravity = whole.gravity;
  chain_.mechanism.bodies.push_back(whole.bodies[ground]);
  body_[ground] = ground;
}

void ChainBuilder::add_body(BodyId b) {
  const Body& body = whole_.bodies[static_cast<std::size_t>(b)];
  body_[static_cast<std::size_t>(b)] = append(body);
  chain_.name += (chain_.name.empty() ? "" : ", ") + body.name;
  carried_.push_back({ParameterOwner::body, body_[static_cast<std::size_t>(b)], b});
}

void ChainBuilder::add_joint(JointId j) {
  Joint joint = whole_.joints[static_cast<std::size_t>(j)];
  joint.first = body_[static_cast<std::size_t>(joint.first)];
  joint.second = body_[static_cast<std::size_t>(joint.second)];
  append(joint, j);
}

void ChainBuilder::add_tip(const TipMass& tip, const VectorX& present) {
  Joint joint = whole_.joints[static_cast<std::size_t>(tip.joint)];
  const bool beyond_first = joint.first == tip.other;
  Attachment mass;
  mass.name = "share at " + joint.name;
  mass.kind = AttachmentKind::payload;
  mass.mass = tip.mass.dot(present);
  if (is_point_joint(joint.type)) {
    mass.body = body_[static_cast<std::size_t>(beyond_first ? joint.second : joint.first)];
    mass.position = beyond_first ? joint.point_second : joint.point_first;
  } else {
    Body end;
    end.name = whole_.bodies[static_cast<std::size_t>(tip.other)].name;
    mass.body = append(end);
    mass.position = beyond_first ? joint.point_first : joint.point_second;
    joint.first = beyond_first ? mass.body : body_[static_cast<std::size_t>(joint.first)];
    joint.second = beyond_first ? body_[static_cast<std::size_t>(joint.second)] : mass.body;
    append(joint, tip.joint);
  }
  add_mass(mass, tip.mass);
}

void ChainBuilder::add_attached_elements() {
  Mechanism& m = chain_.mechanism;
  m.coordinates = list_coordinates(m.space, m.joints);
  find_coordinates();
  for (std::size_t a = 0; a < whole_.attachments.size(); ++a) add_attachment(static_cast<int>(a));
  for (std::size_t d = 0; d < whole_.discs.size(); ++d) add_disc(static_cast<int>(d));
  for (std::size_t s = 0; s < whole_.springs.size(); ++s) add_spring(static_cast<int>(s));
  add_loads_and_friction();
  for (Coupling coupling : whole_.couplings) {
    coupling.follower = to_chain_coordinate(coupling.follower);
    if (coupling.follower >= 0 && map_to_chain(coupling.leader)) m.couplings.push_back(coupling);
  }
  for (const int c : whole_.actuators)
    if (to_chain_coordinate(c) >= 0) m.actuators.push_back(to_chain_coordinate(c));
  for (const CoordinateValue& value : whole_.assembly)
    if (to_chain_coordinate(value.coordinate) >= 0)
      m.assembly.push_back({to_chain_coordinate(value.coordinate), value.value});
}

Chain ChainBuilder::build(MatrixX& left_over) {
  const ParameterColumns own(list_terms(chain_.mechanism, chain_.loose_springs));
  chain_.parameters = MatrixX::Zero(own.count(), columns_.count());
  for (const SharedParameters& c : carried_) {
    const Index size = own.size(c.bearer, c.index), from = columns_.first(c.bearer, c.whole_index);
    chain_.parameters.block(own.first(c.bearer, c.index), from, size, size).setIdentity();
    left_over.block(from, from, size, size).setZero();
  }
  for (const TipAttachment& p : points_) {
    const Vector3& r = chain_.mechanism.attachments[static_cast<std::size_t>(p.attachment)].position;
    chain_.parameters.middleRows(own.first(ParameterOwner::attachment, p.attachment),
                                 own.size(ParameterOwner::attachment, p.attachment)) +=
        point_mass_parameters(whole_.space, r) * p.mass.transpose();
    if (p.parameter >= 0) left_over(p.parameter, p.parameter) = 0;
  }
  return std::move(chain_);
}

BodyId ChainBuilder::append(const Body& body) {
  chain_.mechanism.bodies.push_back(body);
  return static_cast<int>(chain_.mechanism.bodies.size()) - 1;
}

void ChainBuilder::append(const Joint& joint, JointId whole) {
  chain_.mechanism.joints.push_back(joint);
  joints_.push_back(whole);
}

void ChainBuilder::add_mass(const Attachment& mass, const VectorX& linear, Index taken) {
  chain_.mechanism.attachments.push_back(mass);
  points_.push_back({static_cast<int>(chain_.mechanism.attachments.size()) - 1, linear, taken});
}

void ChainBuilder::find_coordinates() {
  const auto& own = chain_.mechanism.coordinates;
  for (std::size_t c = 0; c < own.size(); ++c)
    for (std::size_t w = 0; w < whole_.coordinates.size(); ++w)
      if (whole_.coordinates[w].joint == joints_[static_cast<std::size_t>(own[c].joint)] &&
          whole_.coordinates[w].index == own[c].index)
        coordinate_[w] = static_cast<int>(c);
}

void ChainBuilder::add_attachment(int a) {
  Attachment attachment = whole_.attachments[static_cast<std::size_t>(a)];
  if (!is_own(attachment.body)) return;
  attachment.body = body_[static_cast<std::size_t>(attachment.body)];
  chain_.mechanism.attachments.push_back(attachment);
  carried_.push_back({ParameterOwner::attachment, static_cast<int>(chain_.mechanism.attachments.size()) - 1, a});
}

/// @return whether all that is followed are coordinates of this chain
bool ChainBuilder::map_to_chain(CoordinateCombination& followed) const {
  for (CoordinateTerm& term : followed.terms) {
    term.coordinate = to_chain_coordinate(term.coordinate);
    if (term.coordinate < 0) return false;
  }
  return true;
}

/// A disc that follows a coordinate of another chain loads this one with its mass; what its spin does is left over.
void ChainBuilder::add_disc(int d) {
  Disc disc = whole_.discs[static_cast<std::size_t>(d)];
  const bool led_here = map_to_chain(disc.follows);
  if (!has_body(disc.body) || (disc.body == ground && !led_here)) return;
  disc.body = body_[static_cast<std::size_t>(disc.body)];
  if (led_here) {
    chain_.mechanism.discs.push_back(disc);
    carried_.push_back({ParameterOwner::disc, static_cast<int>(chain_.mechanism.discs.size()) - 1, d});
  } else {
    const Index mass = columns_.first(ParameterOwner::disc, d);
    add_mass({disc.name, AttachmentKind::counterweight, disc.body, disc.position, disc.mass, Matrix3::Zero()},
             VectorX::Unit(columns_.count(), mass), mass);
  }
}

void ChainBuilder::add_loads_and_friction() {
  Mechanism& m = chain_.mechanism;
  for (std::size_t l = 0; l < whole_.loads.size(); ++l) {
    Load load = whole_.loads[l];
    if (!is_own(load.body)) continue;
    load.body = body_[static_cast<std::size_t>(load.body)];
    m.loads.push_back(load);
    carried_.push_back({ParameterOwner::load, static_cast<int>(m.loads.size()) - 1, static_cast<int>(l)});
  }
  for (std::size_t f = 0; f < whole_.friction.size(); ++f) {
    Friction friction = whole_.friction[f];
    if (to_chain_coordinate(friction.coordinate) < 0) continue;
    friction.coordinate = to_chain_coordinate(friction.coordinate);
    m.friction.push_back(friction);
    carried_.push_back({ParameterOwner::friction, static_cast<int>(m.friction.size()) - 1, static_cast<int>(f)});
  }
}

void ChainBuilder::add_spring(int s) {
  Spring spring = whole_.springs[static_cast<std::size_t>(s)];
  if (spring.is_joint_spring()) {
    spring.coordinate = to_chain_coordinate(spring.coordinate);
    if (!spring.is_joint_spring()) return;
  } else {
    if (!has_body(spring.first) || !has_body(spring.second) || (!is_own(spring.first) && !is_own(spring.second)))
      return;
    spring.first = body_[static_cast<std::size_t>(spring.first)];
    spring.second = body_[static_cast<std::size_t>(spring.second)];
  }
  chain_.mechanism.springs.push_back(spring);
  const auto index = static_cast<std::size_t>(s);
  chain_.loose_springs.push_back(index < loose_.size() && loose_[index]);
  carried_.push_back({ParameterOwner::spring, static_cast<int>(chain_.mechanism.springs.size()) - 1, s});
}

}  // namespace balance
