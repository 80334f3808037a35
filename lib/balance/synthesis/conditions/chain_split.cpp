#include "balance/synthesis/conditions/chain_split.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/conditions/graph_partition.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::conditions {

using dynamics::ParameterOwner;

using Eigen::Index;

VectorX point_mass_parameters(SpaceKind space, const Vector3& r) {
  if (space == SpaceKind::planar) return Eigen::Vector4d(1, r.x(), r.y(), r.head<2>().squaredNorm());
  VectorX pi(10);
  pi << 1, r, r.y() * r.y() + r.z() * r.z(), r.x() * r.x() + r.z() * r.z(), r.x() * r.x() + r.y() * r.y(),
      -r.x() * r.y(), -r.x() * r.z(), -r.y() * r.z();
  return pi;
}

ParameterColumns::ParameterColumns(const std::vector<dynamics::Parameter>& parameters)
    : count_(static_cast<Index>(parameters.size())) {
  for (Index p = 0; p < count_; ++p) {
    const dynamics::Parameter& parameter = parameters[static_cast<std::size_t>(p)];
    ++ranges_.try_emplace({parameter.owner_kind, parameter.index}, p, 0).first->second.second;
  }
}

ChainBuilder::ChainBuilder(const Mechanism& whole, const dynamics::FreeSprings& loose, const ParameterColumns& columns)
    : whole_(whole),
      loose_(loose),
      columns_(columns),
      chain_body_(whole.bodies.size(), -1),
      chain_coordinate_(whole.coordinates.size(), -1) {
  chain_.mechanism.name = whole.name;
  chain_.mechanism.space = whole.space;
  chain_.mechanism.gravity = whole.gravity;
  chain_.mechanism.bodies.push_back(whole.bodies[model::ground]);
  chain_body_[model::ground] = model::ground;
}

void ChainBuilder::add_body(BodyId b) {
  const Body& body = whole_.bodies[static_cast<std::size_t>(b)];
  chain_body_[static_cast<std::size_t>(b)] = append(body);
  chain_.name += (chain_.name.empty() ? "" : ", ") + body.name;
  shared_parameters_.push_back({ParameterOwner::body, chain_body_[static_cast<std::size_t>(b)], b});
}

void ChainBuilder::add_joint(JointId j) {
  Joint joint = whole_.joints[static_cast<std::size_t>(j)];
  joint.first = chain_body_[static_cast<std::size_t>(joint.first)];
  joint.second = chain_body_[static_cast<std::size_t>(joint.second)];
  append(joint, j);
}

void ChainBuilder::add_tip(const TipMass& tip, const VectorX& current_values) {
  Joint joint = whole_.joints[static_cast<std::size_t>(tip.joint)];
  const bool is_other_first = joint.first == tip.other;
  Attachment mass;
  mass.name = "share at " + joint.name;
  mass.kind = AttachmentKind::payload;
  mass.mass = tip.mass.dot(current_values);
  if (is_point_joint(joint.type)) {
    mass.body = chain_body_[static_cast<std::size_t>(is_other_first ? joint.second : joint.first)];
    mass.position = is_other_first ? joint.point_second : joint.point_first;
  } else {
    Body tip_body;
    tip_body.name = whole_.bodies[static_cast<std::size_t>(tip.other)].name;
    mass.body = append(tip_body);
    mass.position = is_other_first ? joint.point_first : joint.point_second;
    joint.first = is_other_first ? mass.body : chain_body_[static_cast<std::size_t>(joint.first)];
    joint.second = is_other_first ? chain_body_[static_cast<std::size_t>(joint.second)] : mass.body;
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
  add_known_terms();
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

Chain ChainBuilder::build(MatrixX& remainder_map) {
  const ParameterColumns chain_columns(list_terms(chain_.mechanism, chain_.loose_springs));
  chain_.parameters = MatrixX::Zero(chain_columns.count(), columns_.count());
  for (const SharedParameters& c : shared_parameters_) {
    const Index size = chain_columns.size(c.owner_kind, c.index),
                whole_first = columns_.first(c.owner_kind, c.whole_index);
    chain_.parameters.block(chain_columns.first(c.owner_kind, c.index), whole_first, size, size).setIdentity();
    remainder_map.block(whole_first, whole_first, size, size).setZero();
  }
  for (const TipAttachment& p : tip_attachments_) {
    const Vector3& r = chain_.mechanism.attachments[static_cast<std::size_t>(p.attachment)].position;
    chain_.parameters.middleRows(chain_columns.first(ParameterOwner::attachment, p.attachment),
                                 chain_columns.size(ParameterOwner::attachment, p.attachment)) +=
        point_mass_parameters(whole_.space, r) * p.mass.transpose();
    if (p.parameter >= 0) remainder_map(p.parameter, p.parameter) = 0;
  }
  return std::move(chain_);
}

BodyId ChainBuilder::append(const Body& body) {
  chain_.mechanism.bodies.push_back(body);
  return static_cast<int>(chain_.mechanism.bodies.size()) - 1;
}

void ChainBuilder::append(const Joint& joint, JointId whole) {
  chain_.mechanism.joints.push_back(joint);
  whole_joints_.push_back(whole);
}

void ChainBuilder::add_mass(const Attachment& mass, const VectorX& coefficients, Index parameter) {
  chain_.mechanism.attachments.push_back(mass);
  tip_attachments_.push_back({static_cast<int>(chain_.mechanism.attachments.size()) - 1, coefficients, parameter});
}

void ChainBuilder::find_coordinates() {
  const auto& coordinates = chain_.mechanism.coordinates;
  for (std::size_t c = 0; c < coordinates.size(); ++c)
    for (std::size_t w = 0; w < whole_.coordinates.size(); ++w)
      if (whole_.coordinates[w].joint == whole_joints_[static_cast<std::size_t>(coordinates[c].joint)] &&
          whole_.coordinates[w].index == coordinates[c].index)
        chain_coordinate_[w] = static_cast<int>(c);
}

void ChainBuilder::add_attachment(int a) {
  Attachment attachment = whole_.attachments[static_cast<std::size_t>(a)];
  if (!is_chain_body(attachment.body)) return;
  attachment.body = chain_body_[static_cast<std::size_t>(attachment.body)];
  chain_.mechanism.attachments.push_back(attachment);
  shared_parameters_.push_back(
      {ParameterOwner::attachment, static_cast<int>(chain_.mechanism.attachments.size()) - 1, a});
}

/// @return whether all followed coordinates belong to this chain
bool ChainBuilder::map_to_chain(model::CoordinateCombination& followed) const {
  for (model::CoordinateTerm& term : followed.terms) {
    term.coordinate = to_chain_coordinate(term.coordinate);
    if (term.coordinate < 0) return false;
  }
  return true;
}

/// If a disc follows a coordinate of another chain, this chain carries its mass; the effect of its spin stays
/// unassigned.
void ChainBuilder::add_disc(int d) {
  Disc disc = whole_.discs[static_cast<std::size_t>(d)];
  const bool is_driven_within_chain = map_to_chain(disc.follows);
  if (!has_body(disc.body) || (disc.body == model::ground && !is_driven_within_chain)) return;
  disc.body = chain_body_[static_cast<std::size_t>(disc.body)];
  if (is_driven_within_chain) {
    chain_.mechanism.discs.push_back(disc);
    shared_parameters_.push_back({ParameterOwner::disc, static_cast<int>(chain_.mechanism.discs.size()) - 1, d});
  } else {
    const Index mass = columns_.first(ParameterOwner::disc, d);
    add_mass({disc.name, AttachmentKind::counterweight, disc.body, disc.position, disc.mass, Matrix3::Zero()},
             VectorX::Unit(columns_.count(), mass), mass);
  }
}

/// Moves the ends of a force between points, or the coordinate of one in a joint, to this chain.
/// @return whether it acts on this chain and on nothing else
template <class Element>
bool ChainBuilder::map_ends_to_chain(Element& element) const {
  if (element.coordinate >= 0) {
    element.coordinate = to_chain_coordinate(element.coordinate);
    return element.coordinate >= 0;
  }
  if (!has_body(element.first) || !has_body(element.second) ||
      (!is_chain_body(element.first) && !is_chain_body(element.second)))
    return false;
  element.first = chain_body_[static_cast<std::size_t>(element.first)];
  element.second = chain_body_[static_cast<std::size_t>(element.second)];
  return true;
}

void ChainBuilder::add_known_terms() {
  Mechanism& m = chain_.mechanism;
  for (std::size_t l = 0; l < whole_.loads.size(); ++l) {
    Load load = whole_.loads[l];
    if (!is_chain_body(load.body)) continue;
    load.body = chain_body_[static_cast<std::size_t>(load.body)];
    if (load.is_over_coordinate()) load.coordinate = to_chain_coordinate(load.coordinate);
    m.loads.push_back(load);
    shared_parameters_.push_back({ParameterOwner::load, static_cast<int>(m.loads.size()) - 1, static_cast<int>(l)});
  }
  for (std::size_t f = 0; f < whole_.friction.size(); ++f) {
    Friction friction = whole_.friction[f];
    if (to_chain_coordinate(friction.coordinate) < 0) continue;
    friction.coordinate = to_chain_coordinate(friction.coordinate);
    m.friction.push_back(friction);
    shared_parameters_.push_back(
        {ParameterOwner::friction, static_cast<int>(m.friction.size()) - 1, static_cast<int>(f)});
  }
  for (std::size_t e = 0; e < whole_.force_elements.size(); ++e) {
    ForceElement element = whole_.force_elements[e];
    if (!map_ends_to_chain(element)) continue;
    m.force_elements.push_back(element);
    shared_parameters_.push_back(
        {ParameterOwner::force_element, static_cast<int>(m.force_elements.size()) - 1, static_cast<int>(e)});
  }
}

void ChainBuilder::add_spring(int s) {
  Spring spring = whole_.springs[static_cast<std::size_t>(s)];
  if (!map_ends_to_chain(spring)) return;
  chain_.mechanism.springs.push_back(spring);
  const auto index = static_cast<std::size_t>(s);
  chain_.loose_springs.push_back(index < loose_.size() && loose_[index]);
  shared_parameters_.push_back({ParameterOwner::spring, static_cast<int>(chain_.mechanism.springs.size()) - 1, s});
}

namespace {

using Eigen::Index;

class ChainSplitter {
 public:
  ChainSplitter(const Mechanism& whole, const dynamics::FreeSprings& loose)
      : whole_(whole),
        loose_(loose),
        dimension_(whole.space == SpaceKind::planar ? 2 : 3),
        parameters_(list_terms(whole, loose)),
        columns_(parameters_),
        partition_(partition_graph(whole)),
        tips_(static_cast<std::size_t>(partition_.chains)) {}

  ChainSplit run() {
    split_.failure_reason = partition_.failure_reason;
    split_.is_serial = partition_.platforms.empty() && partition_.opened_joints.empty();
    if (!split_.failure_reason.empty() || split_.is_serial) return std::move(split_);
    for (const Load& load : whole_.loads) check_load_argument(load);
    if (!split_.failure_reason.empty()) return std::move(split_);
    split_.unassigned = MatrixX::Identity(columns_.count(), columns_.count());
    for (const Platform& platform : partition_.platforms) distribute_platform_mass(platform);
    for (const JointId joint : partition_.opened_joints) open_loop(joint);
    for (int chain = 0; chain < partition_.chains; ++chain) build(chain);
    describe();
    return std::move(split_);
  }

 private:
  const Joint& joint(int j) const { return whole_.joints[static_cast<std::size_t>(j)]; }
  /// A chain is balanced by itself, so its loads must not depend on the coordinates of others.
  void check_load_argument(const Load& load) {
    if (!load.is_over_coordinate()) return;
    const Coordinate& coordinate = whole_.coordinates[static_cast<std::size_t>(load.coordinate)];
    const Joint& moved = joint(coordinate.joint);
    if (chain_of(load.body) < 0 ||
        (chain_of(moved.first) != chain_of(load.body) && chain_of(moved.second) != chain_of(load.body)))
      split_.failure_reason = fmt::format("the load {} depends on {}, which is not in the chain that it acts on",
                                          load.name, coordinate.name);
  }
  int chain_of(BodyId body) const { return partition_.chain_of[static_cast<std::size_t>(body)]; }

  void add_tip(int j, int other, const VectorX& mass) {
    const int chain_body = joint(j).first == other ? joint(j).second : joint(j).first;
    tips_[static_cast<std::size_t>(chain_of(chain_body))].push_back({j, other, mass});
  }

  /// Mass and first moments of a body with everything on it, linear in the parameters: (1 + d) × P.
  MatrixX moments(BodyId body) const {
    MatrixX sum = MatrixX::Zero(1 + dimension_, columns_.count());
    const auto add_element = [&](ParameterOwner owner_kind, std::size_t index) {
      const Index first = columns_.first(owner_kind, static_cast<int>(index));
      sum.middleCols(first, 1 + dimension_) += MatrixX::Identity(1 + dimension_, 1 + dimension_);
    };
    add_element(ParameterOwner::body, static_cast<std::size_t>(body));
    for (std::size_t a = 0; a < whole_.attachments.size(); ++a)
      if (whole_.attachments[a].body == body) add_element(ParameterOwner::attachment, a);
    for (std::size_t k = 0; k < whole_.discs.size(); ++k)
      if (whole_.discs[k].body == body) {
        const Index mass = columns_.first(ParameterOwner::disc, static_cast<int>(k));
        sum(0, mass) += 1;
        sum.col(mass).tail(dimension_) += whole_.discs[k].position.head(dimension_);
      }
    return sum;
  }

  /// Equal masses at the joints plus the minimum-norm correction that moves the CoM: wᵢ = m / n + dᵢᵀ (Σ d dᵀ)⁺ (m r −
  /// m r̄), with d the joints' positions relative to their mean r̄.
  void distribute_platform_mass(const Platform& platform) {
    const auto n = static_cast<Index>(platform.joints.size());
    MatrixX joint_positions(dimension_, n);
    for (Index i = 0; i < n; ++i) {
      const Joint& platform_joint = joint(platform.joints[static_cast<std::size_t>(i)]);
      joint_positions.col(i) =
          (platform_joint.first == platform.body ? platform_joint.point_first : platform_joint.point_second)
              .head(dimension_);
    }
    const VectorX mean = joint_positions.rowwise().mean();
    const MatrixX platform_moments = moments(platform.body);
    numerics::CompleteOrthogonalDecomposition solver;
    solver.setThreshold(coincidence_tolerance);
    solver.compute(joint_positions.colwise() - mean);
    MatrixX joint_masses = solver.solve(platform_moments.bottomRows(dimension_) - mean * platform_moments.row(0));
    joint_masses.rowwise() += platform_moments.row(0) / static_cast<double>(n);
    std::string text;
    const Index first_column = columns_.first(ParameterOwner::body, platform.body),
                size = columns_.size(ParameterOwner::body, platform.body);
    for (Index i = 0; i < n; ++i) {
      Vector3 position = Vector3::Zero();
      position.head(dimension_) = joint_positions.col(i);
      const VectorX mass = joint_masses.row(i).transpose();
      split_.unassigned.middleRows(first_column, size) -=
          point_mass_parameters(whole_.space, position) * mass.transpose();
      const int joint_id = platform.joints[static_cast<std::size_t>(i)];
      add_tip(joint_id, platform.body, mass);
      text += (text.empty() ? "" : "; ") +
              ("at " + joint(joint_id).name + ": " + linear_combination_text(parameters_, mass));
    }
    split_.notes.push_back("the chains carry point masses " + text);
    // Cancelled up to round-off.
    for (double& entry : split_.unassigned.reshaped())
      if (std::abs(entry) < 1e-14 * std::max(1.0, numerics::max_abs(joint_positions))) entry = 0;
    if (solver.rank() < dimension_)
      split_.notes.push_back(
          fmt::format("the joints of {} lie on one {}: point masses there reproduce its CoM only along it",
                      name(platform.body), solver.rank() == 2 ? "plane" : "line"));
  }

  /// Moves half of every payload at the joint's point to the chain on the other side. With payloads on both bodies, the
  /// spec itself defines the shares.
  void open_loop(int j) {
    const Joint& opened = joint(j);
    bool has_first_payload = false, has_second_payload = false;
    VectorX transferred_mass = VectorX::Zero(columns_.count());  // from the first body's chain to the second's
    for (std::size_t a = 0; a < whole_.attachments.size() && is_point_joint(opened.type); ++a) {
      const Attachment& payload = whole_.attachments[a];
      const bool first = payload.body == opened.first, second = payload.body == opened.second;
      if (payload.kind != AttachmentKind::payload || (!first && !second)) continue;
      const Vector3 offset = payload.position - (first ? opened.point_first : opened.point_second);
      if (offset.norm() > coincidence_tolerance * characteristic_length(whole_)) continue;
      (first ? has_first_payload : has_second_payload) = true;
      transferred_mass[columns_.first(ParameterOwner::attachment, static_cast<int>(a))] = first ? 0.5 : -0.5;
    }
    if (has_first_payload && has_second_payload) {
      split_.notes.push_back(fmt::format("at {}, {} and {} keep their own payloads", opened.name, name(opened.first),
                                         name(opened.second)));
      return;
    }
    if (transferred_mass.isZero(0)) return;
    add_tip(j, opened.second, -transferred_mass);
    add_tip(j, opened.first, transferred_mass);
    split_.notes.push_back(fmt::format("at {}, {} is transferred from {} to {}", opened.name,
                                       linear_combination_text(parameters_, transferred_mass), name(opened.first),
                                       name(opened.second)));
  }

  void build(int chain) {
    ChainBuilder builder(whole_, loose_, columns_);
    for (std::size_t b = 1; b < whole_.bodies.size(); ++b)
      if (partition_.chain_of[b] == chain) builder.add_body(static_cast<int>(b));
    for (std::size_t j = 0; j < whole_.joints.size(); ++j) {
      const int a = whole_.joints[j].first, b = whole_.joints[j].second;
      const bool is_opened = std::find(partition_.opened_joints.begin(), partition_.opened_joints.end(),
                                       static_cast<int>(j)) != partition_.opened_joints.end();
      if (!is_opened && builder.has_body(a) && builder.has_body(b) && (a != model::ground || b != model::ground))
        builder.add_joint(static_cast<int>(j));
    }
    const VectorX current_values = term_values(whole_, loose_);
    for (const TipMass& tip : tips_[static_cast<std::size_t>(chain)]) builder.add_tip(tip, current_values);
    builder.add_attached_elements();
    split_.chains.push_back(builder.build(split_.unassigned));
  }

  const std::string& name(BodyId body) const { return whole_.bodies[static_cast<std::size_t>(body)].name; }

  void describe() {
    std::string names, cut;
    for (const Chain& chain : split_.chains) names += (names.empty() ? "(" : ", (") + chain.name + ")";
    for (const Platform& platform : partition_.platforms)
      cut += (cut.empty() ? "at " : " and at ") + name(platform.body);
    for (const int j : partition_.opened_joints) cut += (cut.empty() ? "at joint " : " and at joint ") + joint(j).name;
    split_.notes.insert(split_.notes.begin(), fmt::format("split {} into the chains {}", cut, names));
    std::size_t couplings = 0;
    for (const Chain& chain : split_.chains) couplings += chain.mechanism.couplings.size();
    if (couplings < whole_.couplings.size())
      split_.notes.push_back(
          "couplings between different chains are left out: the chains are balanced for more motions than "
          "the mechanism has");
    if (whole_.space == SpaceKind::planar)
      for (const Platform& platform : partition_.platforms)
        split_.notes.push_back(fmt::format(
            "the point masses and {} differ in moment of inertia: {} is left over", name(platform.body),
            linear_combination_text(
                parameters_,
                split_.unassigned.row(columns_.first(ParameterOwner::body, platform.body) + 3).transpose())));
  }

  const Mechanism& whole_;
  const dynamics::FreeSprings& loose_;
  Index dimension_;
  std::vector<dynamics::Parameter> parameters_;
  ParameterColumns columns_;
  GraphPartition partition_;
  std::vector<std::vector<TipMass>> tips_;  ///< per chain
  ChainSplit split_;
};

}  // namespace

ChainSplit split_into_chains(const Mechanism& mechanism, const dynamics::FreeSprings& loose) {
  return ChainSplitter(mechanism, loose).run();
}

}  // namespace balance::conditions
