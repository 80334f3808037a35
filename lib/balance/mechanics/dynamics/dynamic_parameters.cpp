#include "balance/mechanics/dynamics/dynamic_parameters.hpp"

#include "balance/mechanics/dynamics/inertia_regressor.hpp"
#include "balance/mechanics/kinematics/tree.hpp"

#include <array>
#include <map>
#include <string_view>

namespace balance::dynamics {

namespace {

struct Symbol {
  std::string_view text;
  ParameterKind kind;
  int length_power;
};

constexpr std::array planar_symbols = {
    Symbol{"m", ParameterKind::mass, 0},
    Symbol{"mx", ParameterKind::first_moment, 1},
    Symbol{"my", ParameterKind::first_moment, 1},
    Symbol{"J", ParameterKind::moment_of_inertia, 2},
};
constexpr std::array spatial_symbols = {
    Symbol{"m", ParameterKind::mass, 0},
    Symbol{"mx", ParameterKind::first_moment, 1},
    Symbol{"my", ParameterKind::first_moment, 1},
    Symbol{"mz", ParameterKind::first_moment, 1},
    Symbol{"Ixx", ParameterKind::moment_of_inertia, 2},
    Symbol{"Iyy", ParameterKind::moment_of_inertia, 2},
    Symbol{"Izz", ParameterKind::moment_of_inertia, 2},
    Symbol{"Ixy", ParameterKind::product_of_inertia, 2},
    Symbol{"Ixz", ParameterKind::product_of_inertia, 2},
    Symbol{"Iyz", ParameterKind::product_of_inertia, 2},
};
constexpr std::string_view axis_letters = "xyz";

std::string_view section_of(ParameterOwner owner_kind, AttachmentKind kind) {
  switch (owner_kind) {
    case ParameterOwner::body: return "bodies";
    case ParameterOwner::attachment: return kind == AttachmentKind::payload ? "payloads" : "counterweights";
    case ParameterOwner::disc: return "discs";
    case ParameterOwner::spring: return "springs";
    case ParameterOwner::load: return "loads";
    case ParameterOwner::friction: return "friction";
    case ParameterOwner::force_element: break;  // known_terms.cpp names them
  }
  return "";
}

/// The list under construction; finish() makes the names unique.
class ParameterList {
 public:
  explicit ParameterList(const Mechanism& mechanism) : mechanism_(mechanism) {}

  void add_inertia(ParameterOwner owner_kind, int index, const std::string& owner) {
    int slot = 0;
    const auto add = [&](const Symbol& symbol) {
      parameters_.push_back(
          {"", owner, std::string(symbol.text), owner_kind, index, slot++, symbol.kind, symbol.length_power});
    };
    if (mechanism_.space == SpaceKind::planar)
      for (const Symbol& symbol : planar_symbols) add(symbol);
    else
      for (const Symbol& symbol : spatial_symbols) add(symbol);
  }

  /// Adds k; for a loose spring also k a, k b and k a bᵀ, with a and b its ends in the bodies' axes; for a joint spring
  /// k and its preload.
  void add_spring(int index, const std::string& owner, bool loose) {
    int slot = 0;
    const auto add = [&](const std::string& symbol, ParameterKind kind, int power) {
      parameters_.push_back({"", owner, symbol, ParameterOwner::spring, index, slot++, kind, power});
    };
    if (const Spring& spring = mechanism_.springs[static_cast<std::size_t>(index)]; spring.is_joint_spring()) {
      const auto coordinate = static_cast<std::size_t>(spring.coordinate);
      const bool is_angle = mechanism_.coordinates[coordinate].kind == CoordinateKind::angle;
      add("k", ParameterKind::stiffness, is_angle ? 2 : 0);
      add("preload", ParameterKind::stiffness_moment, is_angle ? 2 : 1);
      return;
    }
    add("k", ParameterKind::stiffness, 0);
    if (!loose) return;
    const int d = mechanism_.space == SpaceKind::planar ? 2 : 3;
    for (const char end : {'a', 'b'})
      for (int i = 0; i < d; ++i)
        add(std::string("k") + end + axis_letters[static_cast<std::size_t>(i)], ParameterKind::stiffness_moment, 1);
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < d; ++j)
        add(std::string("ka") + axis_letters[static_cast<std::size_t>(i)] + "b" +
                axis_letters[static_cast<std::size_t>(j)],
            ParameterKind::stiffness_moment, 2);
  }

  std::vector<Parameter> finish() {
    std::map<std::string, std::map<std::pair<ParameterOwner, int>, bool>> owners_by_name;
    for (const Parameter& p : parameters_) owners_by_name[p.owner][{p.owner_kind, p.index}] = true;
    for (Parameter& p : parameters_) {
      if (owners_by_name[p.owner].size() > 1) {
        const auto kind = p.owner_kind == ParameterOwner::attachment
                              ? mechanism_.attachments[static_cast<std::size_t>(p.index)].kind
                              : AttachmentKind::counterweight;
        p.owner = std::string(section_of(p.owner_kind, kind)) + "." + p.owner;
      }
      p.name = p.owner + "." + p.symbol;
    }
    return std::move(parameters_);
  }

 private:
  const Mechanism& mechanism_;
  std::vector<Parameter> parameters_;
};

bool is_loose(const FreeSprings& loose, std::size_t spring) { return spring < loose.size() && loose[spring]; }

template <class S>
void add_inertias(const Mechanism& mechanism, std::vector<double>& values) {
  const auto add = [&](double mass, const Vector3& com, const Matrix3& about_com) {
    const VectorX pi = list_inertial_parameters<S>(kinematics::inertia_about_origin<S>(mass, com, about_com));
    values.insert(values.end(), pi.data(), pi.data() + pi.size());
  };
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
    add(mechanism.bodies[b].mass, mechanism.bodies[b].com, mechanism.bodies[b].inertia);
  for (const Attachment& attachment : mechanism.attachments)
    add(attachment.mass, attachment.position, attachment.inertia);
  for (const Disc& disc : mechanism.discs) add(disc.mass, Vector3::Zero(), disc.inertia);
}

void add_spring_values(const Spring& spring, int d, bool loose, std::vector<double>& values) {
  const double k = spring.stiffness;
  const Vector3 &a = spring.point_first, &b = spring.point_second;
  values.push_back(k);
  if (spring.is_joint_spring()) values.push_back(spring.preload);
  if (spring.is_joint_spring() || !loose) return;
  for (const Vector3& end : {a, b})
    for (int i = 0; i < d; ++i) values.push_back(k * end[i]);
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j) values.push_back(k * a[i] * b[j]);
}

}  // namespace

std::string unit_of(const Parameter& parameter) {
  const int power = parameter.length_power;
  switch (parameter.owner_kind) {
    case ParameterOwner::load: return parameter.kind == ParameterKind::couple ? "N m" : "N";
    case ParameterOwner::spring:
      if (parameter.kind == ParameterKind::stiffness) return power == 0 ? "N/m" : "N m/rad";
      return power == 1 ? "N" : "N m";
    case ParameterOwner::force_element:
      if (parameter.kind == ParameterKind::tabulated) return power == 0 ? "N" : "N m";
      [[fallthrough]];
    case ParameterOwner::friction:
      if (parameter.kind == ParameterKind::viscous) return power == 0 ? "N s/m" : "N m s/rad";
      return power == 1 ? "N" : "N m";
    default: return power == 0 ? "kg" : power == 1 ? "kg m" : "kg m^" + std::to_string(power);
  }
}

std::vector<Parameter> list_parameters(const Mechanism& mechanism, const FreeSprings& loose) {
  ParameterList list(mechanism);
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
    list.add_inertia(ParameterOwner::body, static_cast<int>(b), mechanism.bodies[b].name);
  for (std::size_t a = 0; a < mechanism.attachments.size(); ++a)
    list.add_inertia(ParameterOwner::attachment, static_cast<int>(a), mechanism.attachments[a].name);
  for (std::size_t d = 0; d < mechanism.discs.size(); ++d)
    list.add_inertia(ParameterOwner::disc, static_cast<int>(d), mechanism.discs[d].name);
  for (std::size_t s = 0; s < mechanism.springs.size(); ++s)
    list.add_spring(static_cast<int>(s), mechanism.springs[s].name, is_loose(loose, s));
  return list.finish();
}

VectorX parameter_values(const Mechanism& mechanism, const FreeSprings& loose) {
  std::vector<double> values;
  kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
    add_inertias<S>(mechanism, values);
    for (std::size_t s = 0; s < mechanism.springs.size(); ++s)
      add_spring_values(mechanism.springs[s], S::dimension, is_loose(loose, s), values);
  });
  return Eigen::Map<const VectorX>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace balance::dynamics
