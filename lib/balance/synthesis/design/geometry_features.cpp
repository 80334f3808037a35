#include "balance/synthesis/design/geometry_features.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

using dynamics::ParameterOwner;

namespace {

int inertia_size(const Mechanism& mechanism) { return mechanism.space == SpaceKind::planar ? 1 : 6; }

class ValueCollector {
 public:
  void add(double value) { values_.push_back(value); }
  void add(const Vector3& v) { values_.insert(values_.end(), v.data(), v.data() + 3); }
  void add(const Matrix3& m) { values_.insert(values_.end(), m.data(), m.data() + 9); }
  void add_inertia(const Matrix3& i, bool planar) {
    if (planar)
      add(i(2, 2));
    else
      for (const double value : {i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)}) add(value);
  }
  VectorX finish() const {
    return Eigen::Map<const VectorX>(values_.data(), static_cast<Eigen::Index>(values_.size()));
  }

 private:
  std::vector<double> values_;
};

}  // namespace

std::vector<ElementFeatures> list_element_features(const Mechanism& mechanism, const dynamics::FreeSprings& loose) {
  int next = static_cast<int>(conditions::term_values(mechanism, loose).size());
  std::vector<ElementFeatures> all;
  const auto add = [&](ParameterOwner owner, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      ElementFeatures element{owner, static_cast<int>(i), next++, -1};
      if (owner != ParameterOwner::spring) {
        element.inertia = next;
        next += inertia_size(mechanism);
      }
      all.push_back(element);
    }
  };
  add(ParameterOwner::body, 1, mechanism.bodies.size());
  add(ParameterOwner::attachment, 0, mechanism.attachments.size());
  add(ParameterOwner::disc, 0, mechanism.discs.size());
  add(ParameterOwner::spring, 0, mechanism.springs.size());
  return all;
}

VectorX compute_features(const Mechanism& mechanism, const dynamics::FreeSprings& loose) {
  const bool planar = mechanism.space == SpaceKind::planar;
  const VectorX parameters = conditions::term_values(mechanism, loose);
  ValueCollector collector;
  const auto add = [&](double mass, const Matrix3& inertia) {
    collector.add(mass);
    collector.add_inertia(inertia, planar);
  };
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) add(mechanism.bodies[b].mass, mechanism.bodies[b].inertia);
  for (const Attachment& extra : mechanism.attachments) add(extra.mass, extra.inertia);
  for (const Disc& disc : mechanism.discs) add(disc.mass, disc.inertia);
  for (const Spring& spring : mechanism.springs) collector.add(spring.stiffness);
  const VectorX element_values = collector.finish();
  VectorX all(parameters.size() + element_values.size());
  all << parameters, element_values;
  return all;
}

VectorX collect_geometry(const Mechanism& mechanism, const dynamics::FreeSprings& loose) {
  ValueCollector all;
  all.add(mechanism.gravity);
  for (const Joint& joint : mechanism.joints) {
    for (const Vector3& v : {joint.point_first, joint.point_second, joint.axis, joint.axis2}) all.add(v);
    all.add(joint.rotation);
    all.add(joint.radius);
  }
  for (const model::GeneralisedSpeed& constraint : mechanism.constraints)
    for (const model::GeneralisedSpeedTerm& term : constraint.terms) {
      all.add(term.factor);
      all.add(term.position);
    }
  for (const Coupling& coupling : mechanism.couplings) {
    all.add(coupling.ratio);
    for (const model::CoordinateTerm& term : coupling.leader.terms) all.add(term.ratio);
    all.add(coupling.offset);
  }
  for (const Disc& disc : mechanism.discs) {
    all.add(disc.position);
    all.add(disc.axis);
    all.add(disc.ratio);
    for (const model::CoordinateTerm& term : disc.follows.terms) all.add(term.ratio);
  }
  for (std::size_t s = 0; s < mechanism.springs.size(); ++s) {
    const Spring& spring = mechanism.springs[s];
    if (spring.is_joint_spring()) continue;
    all.add(spring.free_length);
    for (const std::optional<double>& length : {spring.slack_length, spring.shortest_length, spring.longest_length})
      all.add(length.value_or(0));
    if (s < loose.size() && loose[s]) continue;
    all.add(spring.point_first);
    all.add(spring.point_second);
  }
  for (const Load& load : mechanism.loads) all.add(load.point);
  for (const ForceElement& element : mechanism.force_elements) {
    all.add(element.point_first);
    all.add(element.point_second);
    for (const auto* numbers : {&element.table.displacement, &element.table.force})
      for (const double number : *numbers) all.add(number);
  }
  if (mechanism.tool) all.add(mechanism.tool->position);
  if (mechanism.torque_distribution)  // the efforts are not linear in its numbers
    for (const model::EffortShare& share : mechanism.torque_distribution->shares) {
      all.add(share.weight);
      for (const std::optional<double>& bound : {share.lower, share.upper, share.preload}) all.add(bound.value_or(0));
    }
  return all.finish();
}

VectorX collect_condition_geometry(const Mechanism& mechanism, const ConditionOptions& options) {
  ValueCollector of_speeds;
  for (const model::GeneralisedSpeed& speed : options.speeds.in(mechanism))
    for (const model::GeneralisedSpeedTerm& term : speed.terms) of_speeds.add(term.position);
  if (options.speeds.depend_on_masses()) {
    const auto add = [&](double mass, const Vector3& position) {
      of_speeds.add(mass);
      of_speeds.add(Vector3(mass * position));
    };
    for (const Body& body : mechanism.bodies) add(body.mass, body.com);
    for (const Attachment& attachment : mechanism.attachments) add(attachment.mass, attachment.position);
    for (const Disc& disc : mechanism.discs) add(disc.mass, disc.position);
  }
  const VectorX geometry = collect_geometry(mechanism, options.loose_springs), more = of_speeds.finish();
  VectorX all(geometry.size() + more.size());
  all << geometry, more;
  return all;
}

VectorX parameter_scales(const Mechanism& mechanism, const dynamics::FreeSprings& loose) {
  const double length = characteristic_length(mechanism), mass = total_mass(mechanism);
  const VectorX values = conditions::term_values(mechanism, loose);
  const auto all = conditions::list_terms(mechanism, loose);
  double stiffness = 0;  // of springs between points, and of torsion springs at a lever arm of the mechanism's length
  for (std::size_t p = 0; p < all.size(); ++p)
    if (all[p].owner_kind == ParameterOwner::spring && all[p].kind == dynamics::ParameterKind::stiffness)
      stiffness = std::max(
          stiffness, std::abs(values[static_cast<Eigen::Index>(p)]) / elementary::pow(length, all[p].length_power));
  VectorX unit(values.size());
  for (std::size_t p = 0; p < all.size(); ++p) {
    if (conditions::is_known_term(all[p])) {
      const double known = std::abs(values[static_cast<Eigen::Index>(p)]);
      unit[static_cast<Eigen::Index>(p)] = known > 0 ? known : 1;
      continue;
    }
    const double size = all[p].owner_kind == ParameterOwner::spring ? stiffness : mass;
    unit[static_cast<Eigen::Index>(p)] = (size > 0 ? size : 1) * elementary::pow(length, all[p].length_power);
  }
  return unit;
}

bool is_equal_to_rounding(const VectorX& a, const VectorX& b) {
  // Rounding may differ even for expressions that do not depend on the free numbers.
  constexpr double equality_tolerance = 1e-14;
  if (a.size() != b.size()) return false;
  return ((a - b).cwiseAbs().array() <= equality_tolerance * a.cwiseAbs().cwiseMax(b.cwiseAbs()).array()).all();
}

}  // namespace balance::design
