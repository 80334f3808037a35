#include "balance/result/limited.hpp"

#include "balance/result/effort_names.hpp"
#include "balance/result/quantities.hpp"
#include "balance/result/recorder.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace balance {
namespace {

using Kind = LimitedQuantity::Kind;

struct Named {
  std::string_view name;
  Kind kind;
};

/// Of the table of quantities. Power is no such quantity: it is a product with s'.
constexpr std::array of_table = {Named{"torque", Kind::force},
                                 Named{"total_torque", Kind::force},
                                 Named{"joint_velocity", Kind::rate},
                                 Named{"joint_acceleration", Kind::force},
                                 Named{"com_velocity", Kind::rate},
                                 Named{"com_acceleration", Kind::force},
                                 Named{"shaking_force", Kind::force},
                                 Named{"shaking_moment", Kind::force},
                                 Named{"shaking_moment_com", Kind::force},
                                 Named{"ground_force", Kind::force},
                                 Named{"ground_moment", Kind::force},
                                 Named{"joint_force", Kind::force},
                                 Named{"joint_moment", Kind::force},
                                 Named{"kinetic_energy", Kind::energy}};

/// A shared name and the quantities that it stands for.
struct Group {
  std::string name;
  bool has_name = true;  ///< false: units differ, so that one bound for all would mean nothing
  std::vector<LimitedQuantity> quantities;
};

const double* efforts(const Sample& sample) { return sample.effort.data(); }
const double* tool_place(const Sample& sample) { return sample.tool_position.data(); }

class Catalogue {
 public:
  explicit Catalogue(const Mechanism& mechanism) {
    name_columns(mechanism, shape_);
    size_arrays(mechanism, 1, {}, shape_);
    const std::vector<Quantity> quantities = all_quantities(shape_);
    for (const Named& named : of_table)
      for (std::size_t q = 0; q < quantities.size(); ++q)
        if (quantities[q].name == named.name && quantities[q].samples->cols() > 0)
          add(quantity_table()[q], quantities[q], named.kind);
    if (!mechanism.tool) return;
    add_whole("tool_velocity", "m/s", Kind::tool_velocity, tool_place, shape_.axes);
    add_whole("tool_acceleration", "m/s^2", Kind::tool_acceleration, tool_place, shape_.axes);
  }

  const std::vector<Group>& groups() const { return groups_; }

 private:
  void add(const QuantityKind& kind, const Quantity& quantity, Kind how) {
    switch (quantity.columns) {
      case Columns::axis: return add_whole(quantity.name, quantity.units.front(), how, kind.values, shape_.axes);
      case Columns::single: return add_single(kind, quantity, how);
      case Columns::coordinate: return add_each(kind, quantity, how, shape_.coordinate_names, 1, 1, 0);
      case Columns::actuator: return add_each(kind, quantity, how, shape_.actuator_names, 1, 1, 0);
      case Columns::joint: return add_each(kind, quantity, how, shape_.joint_names, 3, 1, 2);
      case Columns::joint_axis: return add_each(kind, quantity, how, shape_.joint_names, 3, shape_.axes, 0);
      default: return;
    }
  }

  /// A vector, and each of its components.
  void add_whole(const std::string& name, const std::string& unit, Kind how, const double* (*values)(const Sample&),
                 int axes) {
    groups_.push_back({name, true, {{name, unit, how, values, 0, axes}}});
    const std::vector<std::string> labels = axis_labels(axes);
    for (int i = 0; i < axes; ++i) {
      const std::string component = name + "[" + labels[static_cast<std::size_t>(i)] + "]";
      groups_.push_back({component, true, {{component, unit, how, values, i, 1}}});
    }
  }

  void add_single(const QuantityKind& kind, const Quantity& quantity, Kind how) {
    LimitedQuantity one{quantity.name, quantity.units.front(), how, kind.values, 0, 1};
    if (kind.shape == QuantityKind::Shape::moment) one.first = 2;  // planar, along z
    if (quantity.name == "total_torque") {                         // the magnitude of all efforts
      one.values = efforts;
      one.count = static_cast<int>(shape_.actuator_names.size());
    }
    groups_.push_back({quantity.name, true, {one}});
  }

  void add_each(const QuantityKind& kind, const Quantity& quantity, Kind how, const std::vector<std::string>& owners,
                int stride, int width, int skip) {
    Group all{quantity.name, common_unit(quantity.units) != "mixed", {}};
    std::vector<Group> single;
    for (std::size_t i = 0; i < owners.size(); ++i) {
      const std::string& unit = quantity.unit_of(i, owners.size());
      const LimitedQuantity one{effort_name(quantity.name, unit) + "[" + owners[i] + "]",
                                unit,
                                how,
                                kind.values,
                                static_cast<int>(i) * stride + skip,
                                width};
      all.quantities.push_back(one);
      single.push_back({one.name, true, {one}});
    }
    groups_.push_back(std::move(all));
    groups_.insert(groups_.end(), single.begin(), single.end());
  }

  Result shape_;
  std::vector<Group> groups_;
};

}  // namespace

std::vector<LimitedQuantity> find_limited(const Mechanism& mechanism, const std::string& name) {
  const Catalogue catalogue(mechanism);
  for (const Group& group : catalogue.groups())
    if (group.has_name && is_name_of(name, group.name)) return group.quantities;
  return {};
}

std::vector<std::string> limited_names(const Mechanism& mechanism) {
  const Catalogue catalogue(mechanism);
  std::vector<std::string> names;
  for (const Group& group : catalogue.groups())
    if (group.has_name) names.push_back(group.name);
  return names;
}

}  // namespace balance
