#include "balance/mechanics/results/limitable_quantities.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/recorder.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace balance::results {
namespace {

using Kind = LimitableQuantity::Kind;

struct NamedKind {
  std::string_view name;
  Kind kind;
};

/// Names from the table of quantities. Power is not among them, since it is a product with s'.
constexpr std::array limitable_table = {NamedKind{"torque", Kind::force},
                                        NamedKind{"total_torque", Kind::force},
                                        NamedKind{"joint_velocity", Kind::rate},
                                        NamedKind{"joint_acceleration", Kind::force},
                                        NamedKind{"com_velocity", Kind::rate},
                                        NamedKind{"com_acceleration", Kind::force},
                                        NamedKind{"shaking_force", Kind::force},
                                        NamedKind{"shaking_moment", Kind::force},
                                        NamedKind{"shaking_moment_com", Kind::force},
                                        NamedKind{"ground_force", Kind::force},
                                        NamedKind{"ground_moment", Kind::force},
                                        NamedKind{"joint_force", Kind::force},
                                        NamedKind{"joint_moment", Kind::force},
                                        NamedKind{"kinetic_energy", Kind::energy}};

/// A shared name and the quantities it stands for.
struct QuantityGroup {
  std::string name;
  bool has_name = true;  ///< false: units differ, so a common bound would be meaningless
  std::vector<LimitableQuantity> quantities;
};

const double* effort_values(const Sample& sample) { return sample.effort.data(); }
const double* tool_position_values(const Sample& sample) { return sample.tool_position.data(); }

class LimitableCatalogue {
 public:
  explicit LimitableCatalogue(const Mechanism& mechanism) {
    name_columns(mechanism, shape_);
    resize_arrays(mechanism, 1, {}, shape_);
    const std::vector<Quantity> quantities = list_all_quantities(shape_);
    for (const NamedKind& named : limitable_table)
      for (std::size_t q = 0; q < quantities.size(); ++q)
        if (quantities[q].name == named.name && quantities[q].samples->cols() > 0)
          add(quantity_table()[q], quantities[q], named.kind);
    if (!mechanism.tool) return;
    add_vector("tool_velocity", "m/s", Kind::tool_velocity, tool_position_values, shape_.axes);
    add_vector("tool_acceleration", "m/s^2", Kind::tool_acceleration, tool_position_values, shape_.axes);
  }

  const std::vector<QuantityGroup>& groups() const { return groups_; }

 private:
  void add(const QuantityDefinition& kind, const Quantity& quantity, Kind limit_kind) {
    switch (quantity.columns) {
      case ColumnKind::axis:
        return add_vector(quantity.name, quantity.units.front(), limit_kind, kind.values, shape_.axes);
      case ColumnKind::single: return add_single(kind, quantity, limit_kind);
      case ColumnKind::coordinate: return add_each(kind, quantity, limit_kind, shape_.coordinate_names, 1, 1, 0);
      case ColumnKind::actuator: return add_each(kind, quantity, limit_kind, shape_.actuator_names, 1, 1, 0);
      case ColumnKind::joint: return add_each(kind, quantity, limit_kind, shape_.joint_names, 3, 1, 2);
      case ColumnKind::joint_axis: return add_each(kind, quantity, limit_kind, shape_.joint_names, 3, shape_.axes, 0);
      default: return;
    }
  }

  /// A vector, and each of its components.
  void add_vector(const std::string& name, const std::string& unit, Kind limit_kind,
                  const double* (*values)(const Sample&), int axes) {
    groups_.push_back({name, true, {{name, unit, limit_kind, values, 0, axes}}});
    const std::vector<std::string> labels = axis_labels(axes);
    for (int i = 0; i < axes; ++i) {
      const std::string component = name + "[" + labels[static_cast<std::size_t>(i)] + "]";
      groups_.push_back({component, true, {{component, unit, limit_kind, values, i, 1}}});
    }
  }

  void add_single(const QuantityDefinition& kind, const Quantity& quantity, Kind limit_kind) {
    LimitableQuantity limitable{quantity.name, quantity.units.front(), limit_kind, kind.values, 0, 1};
    if (kind.shape == QuantityDefinition::Shape::moment) limitable.first = 2;  // planar, along z
    if (quantity.name == "total_torque") {                                     // the magnitude of all efforts
      limitable.values = effort_values;
      limitable.count = static_cast<int>(shape_.actuator_names.size());
    }
    groups_.push_back({quantity.name, true, {limitable}});
  }

  void add_each(const QuantityDefinition& kind, const Quantity& quantity, Kind limit_kind,
                const std::vector<std::string>& owners, int stride, int width, int skip) {
    QuantityGroup group{quantity.name, common_unit(quantity.units) != "mixed", {}};
    std::vector<QuantityGroup> single_groups;
    for (std::size_t i = 0; i < owners.size(); ++i) {
      const std::string& unit = quantity.unit_of(i, owners.size());
      const LimitableQuantity limitable{effort_display_name(quantity.name, unit) + "[" + owners[i] + "]",
                                        unit,
                                        limit_kind,
                                        kind.values,
                                        static_cast<int>(i) * stride + skip,
                                        width};
      group.quantities.push_back(limitable);
      single_groups.push_back({limitable.name, true, {limitable}});
    }
    groups_.push_back(std::move(group));
    groups_.insert(groups_.end(), single_groups.begin(), single_groups.end());
  }

  RunResult shape_;
  std::vector<QuantityGroup> groups_;
};

}  // namespace

std::vector<LimitableQuantity> find_limitable_quantities(const Mechanism& mechanism, const std::string& name) {
  const LimitableCatalogue catalogue(mechanism);
  for (const QuantityGroup& group : catalogue.groups())
    if (group.has_name && is_quantity_name(name, group.name)) return group.quantities;
  return {};
}

std::vector<std::string> list_limitable_names(const Mechanism& mechanism) {
  const LimitableCatalogue catalogue(mechanism);
  std::vector<std::string> names;
  for (const QuantityGroup& group : catalogue.groups())
    if (group.has_name) names.push_back(group.name);
  return names;
}

}  // namespace balance::results
