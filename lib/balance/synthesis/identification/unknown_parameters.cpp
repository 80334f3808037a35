#include "balance/synthesis/identification/unknown_parameters.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace balance::identification {

using dynamics::ParameterOwner;

namespace {

template <class T>
T& element_of(std::vector<T>& items, int index) {
  return items[static_cast<std::size_t>(index)];
}
template <class T>
const T& element_of(const std::vector<T>& items, int index) {
  return items[static_cast<std::size_t>(index)];
}

bool is_single_axis(JointType type) {
  return type == JointType::revolute || type == JointType::prismatic || type == JointType::cylindrical ||
         type == JointType::universal || type == JointType::pin_slot;
}

Friction* find_friction(Mechanism& mechanism, CoordinateId coordinate) {
  const auto match = std::find_if(mechanism.friction.begin(), mechanism.friction.end(),
                                  [&](const Friction& friction) { return friction.coordinate == coordinate; });
  return match == mechanism.friction.end() ? nullptr : &*match;
}

/// The spring of zero stiffness that an offset is, if there is one.
Spring* find_offset(Mechanism& mechanism, CoordinateId coordinate) {
  const auto match = std::find_if(mechanism.springs.begin(), mechanism.springs.end(), [&](const Spring& spring) {
    return spring.coordinate == coordinate && spring.stiffness == 0;
  });
  return match == mechanism.springs.end() ? nullptr : &*match;
}

class UnknownList {
 public:
  UnknownList(const Mechanism& mechanism, const UnknownOptions& options)
      : mechanism_(mechanism),
        options_(options),
        parameters_(dynamics::list_parameters(mechanism)),
        values_(dynamics::parameter_values(mechanism)) {}

  std::vector<UnknownParameter> list() {
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b)
      if (mechanism_.bodies[b].mass > 0) add_inertia(ParameterOwner::body, static_cast<int>(b), UnknownKind::body);
    for (std::size_t a = 0; a < mechanism_.attachments.size(); ++a)
      if (is_unknown_payload(mechanism_.attachments[a]))
        add_inertia(ParameterOwner::attachment, static_cast<int>(a), UnknownKind::payload);
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d) add_disc(static_cast<int>(d));
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) add_friction(static_cast<int>(c));
    return std::move(unknowns_);
  }

 private:
  bool is_unknown_payload(const Attachment& attachment) const {
    return std::find(options_.payloads.begin(), options_.payloads.end(), attachment.name) != options_.payloads.end();
  }

  void add_inertia(ParameterOwner owner, int element, UnknownKind kind) {
    const int first = first_inertial_parameter(mechanism_, owner, element);
    for (int slot = 0; slot < inertial_parameter_count(mechanism_); ++slot) {
      const dynamics::Parameter& parameter = element_of(parameters_, first + slot);
      unknowns_.push_back(
          {parameter.name, parameter.owner, unit_of(parameter), kind, element, slot, values_[first + slot]});
    }
  }

  void add_disc(int element) {
    const Disc& disc = element_of(mechanism_.discs, element);
    const double inertia =
        mechanism_.space == SpaceKind::planar ? disc.inertia(2, 2) : disc.axis.dot(disc.inertia * disc.axis);
    unknowns_.push_back({disc.name + ".J", disc.name, "kg m^2", UnknownKind::disc_inertia, element, 0, inertia});
  }

  void add_friction(int coordinate) {
    Mechanism copy;  // only its friction and springs, for look-up
    copy.friction = mechanism_.friction;
    copy.springs = mechanism_.springs;
    const Friction* friction = find_friction(copy, coordinate);
    const Spring* offset = find_offset(copy, coordinate);
    const bool is_actuated =
        std::find(mechanism_.actuators.begin(), mechanism_.actuators.end(), coordinate) != mechanism_.actuators.end();
    const bool is_follower = std::any_of(mechanism_.couplings.begin(), mechanism_.couplings.end(),
                                         [&](const Coupling& coupling) { return coupling.follower == coordinate; });
    const bool is_simple =
        is_single_axis(mechanism_.joints[mechanism_.coordinates[static_cast<std::size_t>(coordinate)].joint].type) &&
        !is_follower;
    const auto passive = is_simple ? options_.passive_friction : PassiveFriction::none;
    const bool is_viscous = friction != nullptr && friction->viscous > 0 && !(friction->static_limit(1) > 0) &&
                            !(friction->static_limit(-1) > 0);
    const bool has_dry = is_actuated || (friction != nullptr && !is_viscous) || passive == PassiveFriction::dry;
    const std::string& name = element_of(mechanism_.coordinates, coordinate).name;
    const bool is_length = is_length_coordinate(mechanism_, coordinate);
    const auto add = [&](const char* what, const char* unit, UnknownKind kind, double value) {
      unknowns_.push_back({name + "." + what, name, unit, kind, coordinate, 0, value});
    };
    if (has_dry || is_viscous || passive == PassiveFriction::viscous)
      add("viscous", is_length ? "N s/m" : "N m s/rad", UnknownKind::viscous, friction ? friction->viscous : 0);
    if (has_dry)
      add("coulomb", is_length ? "N" : "N m", UnknownKind::coulomb,
          friction ? (friction->dry_friction(1) + friction->dry_friction(-1)) / 2 : 0);
    if (is_actuated || offset != nullptr)
      add("offset", is_length ? "N" : "N m", UnknownKind::offset,
          (offset ? -offset->preload : 0) +
              (friction ? (friction->dry_friction(1) - friction->dry_friction(-1)) / 2 : 0));
  }

  const Mechanism& mechanism_;
  const UnknownOptions& options_;
  const std::vector<dynamics::Parameter> parameters_;
  const VectorX values_;
  std::vector<UnknownParameter> unknowns_;
};

constexpr std::array<std::pair<int, int>, 6> tensor_entries{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

/// Mass, centre of mass and inertia about it from the parameters about the origin.
struct CentralInertia {
  double mass = 0;
  Vector3 com = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();
};

CentralInertia to_central(const VectorX& p) {
  CentralInertia out;
  out.mass = p[0];
  const bool is_planar = p.size() == 4;
  const Vector3 moment = is_planar ? Vector3(p[1], p[2], 0) : Vector3(p[1], p[2], p[3]);
  if (out.mass > 0) out.com = moment / out.mass;
  if (is_planar) {
    out.inertia(2, 2) = p[3] - out.mass * out.com.squaredNorm();
    return out;
  }
  for (std::size_t k = 0; k < tensor_entries.size(); ++k) {
    const auto [i, j] = tensor_entries[k];
    out.inertia(i, j) = out.inertia(j, i) = p[4 + static_cast<Eigen::Index>(k)];
  }
  out.inertia -= out.mass * (out.com.squaredNorm() * Matrix3::Identity() - out.com * out.com.transpose());
  return out;
}

}  // namespace

int first_inertial_parameter(const Mechanism& mechanism, ParameterOwner owner, int element) {
  int index = element;
  if (owner == ParameterOwner::body) index -= 1;
  if (owner != ParameterOwner::body) index += static_cast<int>(mechanism.bodies.size()) - 1;
  if (owner == ParameterOwner::disc) index += static_cast<int>(mechanism.attachments.size());
  return index * inertial_parameter_count(mechanism);
}

VectorX axial_inertia_factors(const Mechanism& mechanism, const Disc& disc) {
  VectorX factors = VectorX::Zero(inertial_parameter_count(mechanism));
  if (mechanism.space == SpaceKind::planar) {
    factors[3] = 1;
    return factors;
  }
  for (std::size_t k = 0; k < tensor_entries.size(); ++k)
    factors[4 + static_cast<Eigen::Index>(k)] =
        disc.axis[tensor_entries[k].first] * disc.axis[tensor_entries[k].second];
  return factors;
}

std::vector<UnknownParameter> list_unknowns(const Mechanism& mechanism, const UnknownOptions& options) {
  return UnknownList(mechanism, options).list();
}

Mechanism with_friction_coordinates(const Mechanism& mechanism, const std::vector<UnknownParameter>& unknowns) {
  Mechanism result = mechanism;
  std::erase_if(result.springs, [](const Spring& spring) { return spring.is_joint_spring() && spring.stiffness == 0; });
  for (const UnknownParameter& unknown : unknowns)
    if (is_friction(unknown.kind) && find_friction(result, unknown.element) == nullptr)
      result.friction.push_back({.coordinate = unknown.element});
  return result;
}

Mechanism apply_values(const Mechanism& mechanism, const std::vector<UnknownParameter>& unknowns,
                       const VectorX& values) {
  if (values.size() != static_cast<Eigen::Index>(unknowns.size()))
    throw std::invalid_argument("expected one value per unknown");
  Mechanism result = with_friction_coordinates(mechanism, unknowns);
  const int count = inertial_parameter_count(mechanism);
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    const UnknownParameter& unknown = unknowns[k];
    const double value = values[static_cast<Eigen::Index>(k)];
    if (unknown.kind == UnknownKind::body || unknown.kind == UnknownKind::payload) {
      if (unknown.slot != 0) continue;
      const CentralInertia inertia = to_central(values.segment(static_cast<Eigen::Index>(k), count));
      if (unknown.kind == UnknownKind::body) {
        Body& body = element_of(result.bodies, unknown.element);
        body.mass = inertia.mass, body.com = inertia.com, body.inertia = inertia.inertia;
      } else {
        Attachment& payload = element_of(result.attachments, unknown.element);
        payload.mass = inertia.mass, payload.position = inertia.com, payload.inertia = inertia.inertia;
      }
      continue;
    }
    if (unknown.kind == UnknownKind::disc_inertia) {
      Disc& disc = element_of(result.discs, unknown.element);
      if (mechanism.space == SpaceKind::planar)
        disc.inertia(2, 2) = value;
      else
        disc.inertia += (value - disc.axis.dot(disc.inertia * disc.axis)) * disc.axis * disc.axis.transpose();
      continue;
    }
    if (unknown.kind == UnknownKind::offset) {
      if (value != 0)
        result.springs.push_back({.name = unknown.owner + ".offset", .preload = -value, .coordinate = unknown.element});
      continue;
    }
    Friction& friction = *find_friction(result, unknown.element);
    if (unknown.kind == UnknownKind::viscous) friction.viscous = value;
    if (unknown.kind == UnknownKind::coulomb) {
      friction.coulomb = value;
      friction.coulomb_backward.reset();
      friction.breakaway.reset();
      friction.at_rest_backward.reset();
    }
  }
  return result;
}

VectorX known_inertial_values(const Mechanism& mechanism, const VectorX& all_values,
                              const std::vector<UnknownParameter>& unknowns, const std::vector<std::string>& carried) {
  VectorX values = all_values;
  const int count = inertial_parameter_count(mechanism);
  for (const UnknownParameter& unknown : unknowns) {
    if (unknown.kind == UnknownKind::body || unknown.kind == UnknownKind::payload)
      values[first_inertial_parameter(
                 mechanism, unknown.kind == UnknownKind::body ? ParameterOwner::body : ParameterOwner::attachment,
                 unknown.element) +
             unknown.slot] = 0;
    if (unknown.kind == UnknownKind::disc_inertia)
      values.segment(first_inertial_parameter(mechanism, ParameterOwner::disc, unknown.element), count) -=
          unknown.spec_value * axial_inertia_factors(mechanism, element_of(mechanism.discs, unknown.element));
  }
  for (std::size_t a = 0; a < mechanism.attachments.size(); ++a) {
    const Attachment& attachment = mechanism.attachments[a];
    if (attachment.kind == AttachmentKind::payload &&
        std::find(carried.begin(), carried.end(), attachment.name) == carried.end())
      values.segment(first_inertial_parameter(mechanism, ParameterOwner::attachment, static_cast<int>(a)), count)
          .setZero();
  }
  return values;
}

int column_group(const UnknownParameter& unknown) {
  switch (unknown.kind) {
    case UnknownKind::viscous:
    case UnknownKind::coulomb: return 1;
    case UnknownKind::offset: return 2;
    case UnknownKind::disc_inertia: return 3;
    case UnknownKind::payload:
    case UnknownKind::body: break;
  }
  if (unknown.kind == UnknownKind::payload) return 0;
  return unknown.slot == 0 ? 5 : 4;
}

}  // namespace balance::identification
