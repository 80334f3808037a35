#include "balance/synthesis/conditions/chain_split.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/conditions/graph_partition.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"

#include <fmt/format.h>

#include <algorithm>

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

namespace {

using Eigen::Index;

class ChainSplitter {
 public:
  ChainSplitter(const Mechanism& whole, const FreeSprings& loose)
      : whole_(whole),
        loose_(loose),
        d_(whole.space == SpaceKind::planar ? 2 : 3),
        parameters_(list_terms(whole, loose)),
        columns_(parameters_),
        cuts_(partition_graph(whole)),
        tips_(static_cast<std::size_t>(cuts_.chains)) {}

  ChainSplit run() {
    split_.failure_reason = cuts_.failure_reason;
    split_.is_serial = cuts_.platforms.empty() && cuts_.opened_joints.empty();
    if (!split_.failure_reason.empty() || split_.is_serial) return std::move(split_);
    split_.unassigned = MatrixX::Identity(columns_.count(), columns_.count());
    for (const Platform& platform : cuts_.platforms) distribute_platform_mass(platform);
    for (const JointId joint : cuts_.opened_joints) open_loop(joint);
    for (int chain = 0; chain < cuts_.chains; ++chain) build(chain);
    describe();
    return std::move(split_);
  }

 private:
  const Joint& joint(int j) const { return whole_.joints[static_cast<std::size_t>(j)]; }
  int chain_of(BodyId body) const { return cuts_.chain_of[static_cast<std::size_t>(body)]; }

  void add_tip(int j, int other, const VectorX& mass) {
    const int own = joint(j).first == other ? joint(j).second : joint(j).first;
    tips_[static_cast<std::size_t>(chain_of(own))].push_back({j, other, mass});
  }

  /// Mass and first moments of a body with everything on it, linear in the parameters: (1 + d) × P.
  MatrixX moments(BodyId body) const {
    MatrixX sum = MatrixX::Zero(1 + d_, columns_.count());
    const auto add = [&](ParameterOwner bearer, std::size_t index) {
      const Index first = columns_.first(bearer, static_cast<int>(index));
      sum.middleCols(first, 1 + d_) += MatrixX::Identity(1 + d_, 1 + d_);
    };
    add(ParameterOwner::body, static_cast<std::size_t>(body));
    for (std::size_t a = 0; a < whole_.attachments.size(); ++a)
      if (whole_.attachments[a].body == body) add(ParameterOwner::attachment, a);
    for (std::size_t k = 0; k < whole_.discs.size(); ++k)
      if (whole_.discs[k].body == body) {
        const Index mass = columns_.first(ParameterOwner::disc, static_cast<int>(k));
        sum(0, mass) += 1;
        sum.col(mass).tail(d_) += whole_.discs[k].position.head(d_);
      }
    return sum;
  }

  /// Equal masses at the joints and smallest additions that move the CoM: wᵢ = m / n + dᵢᵀ (Σ d dᵀ)⁺ (m r − m r̄), with d the
  /// joints' places from their mean r̄.
  void distribute_platform_mass(const Platform& platform) {
    const auto n = static_cast<Index>(platform.joints.size());
    MatrixX places(d_, n);
    for (Index i = 0; i < n; ++i) {
      const Joint& at = joint(platform.joints[static_cast<std::size_t>(i)]);
      places.col(i) = (at.first == platform.body ? at.point_first : at.point_second).head(d_);
    }
    const VectorX mean = places.rowwise().mean();
    const MatrixX total = moments(platform.body);
    CompleteOrthogonalDecomposition solver;
    solver.setThreshold(coincidence_tolerance);
    solver.compute(places.colwise() - mean);
    MatrixX shares = solver.solve(total.bottomRows(d_) - mean * total.row(0));
    shares.rowwise() += total.row(0) / static_cast<double>(n);
    std::string text;
    const Index own = columns_.first(ParameterOwner::body, platform.body),
                size = columns_.size(ParameterOwner::body, platform.body);
    for (Index i = 0; i < n; ++i) {
      Vector3 place = Vector3::Zero();
      place.head(d_) = places.col(i);
      const VectorX mass = shares.row(i).transpose();
      split_.unassigned.middleRows(own, size) -= point_mass_parameters(whole_.space, place) * mass.transpose();
      const int at = platform.joints[static_cast<std::size_t>(i)];
      add_tip(at, platform.body, mass);
      text += (text.empty() ? "" : "; ") + ("at " + joint(at).name + ": " + linear_combination_text(parameters_, mass));
    }
    split_.notes.push_back("the chains carry point masses " + text);
    // Cancelled to round-off.
    for (double& entry : split_.unassigned.reshaped())
      if (std::abs(entry) < 1e-14 * std::max(1.0, max_abs(places))) entry = 0;
    if (solver.rank() < d_)
      split_.notes.push_back(
          fmt::format("the joints of {} lie on one {}: point masses there reproduce its CoM only as far as it "
                      "lies on it too",
                      name(platform.body), solver.rank() == 2 ? "plane" : "line"));
  }

  /// Half of every payload at the joint's point goes over to the chain beyond. With payloads there on both bodies the spec says itself
  /// which share is whose.
  void open_loop(int j) {
    const Joint& at = joint(j);
    bool on_first = false, on_second = false;
    VectorX over = VectorX::Zero(columns_.count());  // from the first body's chain to the second's
    for (std::size_t a = 0; a < whole_.attachments.size() && is_point_joint(at.type); ++a) {
      const Attachment& payload = whole_.attachments[a];
      const bool first = payload.body == at.first, second = payload.body == at.second;
      if (payload.kind != AttachmentKind::payload || (!first && !second)) continue;
      const Vector3 gap = payload.position - (first ? at.point_first : at.point_second);
      if (gap.norm() > coincidence_tolerance * characteristic_length(whole_)) continue;
      (first ? on_first : on_second) = true;
      over[columns_.first(ParameterOwner::attachment, static_cast<int>(a))] = first ? 0.5 : -0.5;
    }
    if (on_first && on_second) {
      split_.notes.push_back(
          fmt::format("at {}, {} and {} keep their own payloads", at.name, name(at.first), name(at.second)));
      return;
    }
    if (over.isZero(0)) return;
    add_tip(j, at.second, -over);
    add_tip(j, at.first, over);
    split_.notes.push_back(fmt::format("at {}, {} goes over from {} to {}", at.name,
                                       linear_combination_text(parameters_, over), name(at.first), name(at.second)));
  }

  void build(int chain) {
    ChainBuilder builder(whole_, loose_, columns_);
    for (std::size_t b = 1; b < whole_.bodies.size(); ++b)
      if (cuts_.chain_of[b] == chain) builder.add_body(static_cast<int>(b));
    for (std::size_t j = 0; j < whole_.joints.size(); ++j) {
      const int a = whole_.joints[j].first, b = whole_.joints[j].second;
      const bool opened = std::find(cuts_.opened_joints.begin(), cuts_.opened_joints.end(), static_cast<int>(j)) !=
                          cuts_.opened_joints.end();
      if (!opened && builder.has_body(a) && builder.has_body(b) && (a != ground || b != ground))
        builder.add_joint(static_cast<int>(j));
    }
    const VectorX present = term_values(whole_, loose_);
    for (const TipMass& tip : tips_[static_cast<std::size_t>(chain)]) builder.add_tip(tip, present);
    builder.add_attached_elements();
    split_.chains.push_back(builder.build(split_.unassigned));
  }

  const std::string& name(BodyId body) const { return whole_.bodies[static_cast<std::size_t>(body)].name; }

  void describe() {
    std::string names, cut;
    for (const Chain& chain : split_.chains) names += (names.empty() ? "(" : ", (") + chain.name + ")";
    for (const Platform& platform : cuts_.platforms) cut += (cut.empty() ? "at " : " and at ") + name(platform.body);
    for (const int j : cuts_.opened_joints) cut += (cut.empty() ? "at joint " : " and at joint ") + joint(j).name;
    split_.notes.insert(split_.notes.begin(), fmt::format("split {} into the chains {}", cut, names));
    std::size_t couplings = 0;
    for (const Chain& chain : split_.chains) couplings += chain.mechanism.couplings.size();
    if (couplings < whole_.couplings.size())
      split_.notes.push_back(
          "couplings between different chains are left out: the chains are balanced for more motions than "
          "the mechanism has");
    if (whole_.space == SpaceKind::planar)
      for (const Platform& platform : cuts_.platforms)
        split_.notes.push_back(fmt::format(
            "the point masses have another moment of inertia than {}: {} is left over", name(platform.body),
            linear_combination_text(
                parameters_,
                split_.unassigned.row(columns_.first(ParameterOwner::body, platform.body) + 3).transpose())));
  }

  const Mechanism& whole_;
  const FreeSprings& loose_;
  Index d_;
  std::vector<Parameter> parameters_;
  ParameterColumns columns_;
  GraphPartition cuts_;
  std::vector<std::vector<TipMass>> tips_;  ///< per chain
  ChainSplit split_;
};

}  // namespace

ChainSplit split_into_chains(const Mechanism& mechanism, const FreeSprings& loose) {
  return ChainSplitter(mechanism, loose).run();
}

}  // namespace balance
