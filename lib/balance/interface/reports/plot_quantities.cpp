#include "balance/interface/reports/plot_quantities.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <algorithm>

namespace balance::reports {

using results::ColumnKind;

namespace {

/// A scalar or a vector: adjacent columns of a quantity that belong to one joint, one actuator, or none.
struct QuantityPart {
  std::string member;  ///< "A1"; empty if the quantity has no members
  Eigen::Index first = 0;
  std::vector<std::string> components;  ///< one label per column; none for a scalar
  std::string unit;
};

std::vector<std::string> vector_labels(Eigen::Index columns) { return results::axis_labels(static_cast<int>(columns)); }

std::vector<QuantityPart> parts_of(const Quantity& quantity, const RunResult& result) {
  const Eigen::Index columns = quantity.samples->cols();
  const auto unit = [&](std::size_t i) {
    return quantity.units.size() > 1 ? quantity.units[i] : quantity.units.front();
  };
  const auto members = [&](const std::vector<std::string>& names) {
    const bool is_quaternion = quantity.columns == ColumnKind::body_quaternion;
    std::vector<QuantityPart> parts;
    const Eigen::Index width = columns / static_cast<Eigen::Index>(names.size());
    for (std::size_t i = 0; i < names.size(); ++i)
      parts.push_back({names[i], static_cast<Eigen::Index>(i) * width,
                       is_quaternion ? results::quaternion_labels()
                       : width > 1   ? vector_labels(width)
                                     : std::vector<std::string>(),
                       unit(i)});
    return parts;
  };
  switch (quantity.columns) {
    case ColumnKind::coordinate: return members(result.coordinate_names);
    case ColumnKind::actuator: return members(result.actuator_names);
    case ColumnKind::constraint: return members(result.constraint_names);
    case ColumnKind::sliding: return members(result.sliding_names);
    case ColumnKind::joint:
    case ColumnKind::joint_axis: return members(result.joint_names);
    case ColumnKind::body:
    case ColumnKind::body_axis:
    case ColumnKind::body_quaternion: return members(result.body_names);
    case ColumnKind::axis: return {{"", 0, vector_labels(columns), unit(0)}};
    case ColumnKind::quaternion: return {{"", 0, results::quaternion_labels(), unit(0)}};
    case ColumnKind::single: break;
  }
  return {{"", 0, {}, unit(0)}};
}

std::string member_name(const Quantity& quantity, const QuantityPart& part) {
  return part.member.empty() ? quantity.name
                             : results::effort_display_name(quantity.name, part.unit) + "[" + part.member + "]";
}

std::string joined(const std::string& a, const std::string& b) { return a.empty() || b.empty() ? a + b : a + " " + b; }

void add_part(PlotQuantity& plot, const Quantity& quantity, const QuantityPart& part, VectorView view) {
  const Samples& samples = *quantity.samples;
  const auto width = static_cast<Eigen::Index>(part.components.size());
  if (width == 0) {
    plot.curves.push_back({part.member, samples.col(part.first)});
    plot.not_negative = false;
    return;
  }
  // the magnitude of a unit quaternion is meaningless
  if (quantity.columns == ColumnKind::quaternion || quantity.columns == ColumnKind::body_quaternion)
    view = VectorView::components;
  if (view != VectorView::components) {
    const std::string label = view == VectorView::both ? "magnitude" : "";
    plot.curves.push_back({joined(part.member, label), samples.middleCols(part.first, width).rowwise().norm()});
  }
  if (view == VectorView::magnitude) return;
  plot.not_negative = false;
  for (Eigen::Index i = 0; i < width; ++i)
    plot.curves.push_back(
        {joined(part.member, part.components[static_cast<std::size_t>(i)]), samples.col(part.first + i)});
}

/// "shaking force"; actuator efforts in newtons are called forces.
std::string title_of(const Quantity& quantity, const std::string& unit) {
  std::string title = quantity.name;
  if (title == "torque" && unit == "N") return "actuator force";
  title = results::effort_display_name(title, unit);
  if (title.starts_with("com_")) title.replace(0, 3, "CoM");
  std::replace(title.begin(), title.end(), '_', ' ');
  return title;
}

PlotQuantity make_plot_quantity(const Quantity& quantity, const std::vector<QuantityPart>& parts,
                                const std::string& name, VectorView view) {
  PlotQuantity plot;
  plot.name = name;
  std::vector<std::string> units;
  for (const QuantityPart& part : parts) {
    units.push_back(part.unit);
    add_part(plot, quantity, part, view);
  }
  plot.unit = results::common_unit(units);
  plot.title = title_of(quantity, plot.unit);
  plot.is_effort = quantity.member == &RunResult::torque;
  if (parts.size() == 1) plot.title = joined(plot.title, parts.front().member);
  if (plot.curves.size() == 1) plot.curves.front().label.clear();
  return plot;
}

/// One column as a quantity of its own.
PlotQuantity make_component(const Quantity& quantity, const QuantityPart& part, std::size_t component,
                            const std::string& name) {
  PlotQuantity plot;
  plot.name = name;
  plot.unit = part.unit;
  plot.title = joined(joined(title_of(quantity, part.unit), part.member), part.components[component]);
  plot.not_negative = false;
  plot.curves.push_back({"", quantity.samples->col(part.first + static_cast<Eigen::Index>(component))});
  return plot;
}

constexpr const char* iterations_name = "newton_iterations";

}  // namespace

std::vector<std::string> list_plot_names(const RunResult& result) {
  std::vector<std::string> names;
  for (const Quantity& quantity : list_sampled_quantities(result)) {
    names.push_back(quantity.name);
    for (const QuantityPart& part : parts_of(quantity, result)) {
      if (!part.member.empty()) names.push_back(member_name(quantity, part));
      for (const std::string& component : part.components)
        names.push_back(member_name(quantity, part) + "." + component);
    }
  }
  if (result.newton_iterations.size() > 0) names.emplace_back(iterations_name);
  return names;
}

std::optional<PlotQuantity> find_plot_quantity(const RunResult& result, const std::string& name, VectorView view) {
  if (name == iterations_name && result.newton_iterations.size() > 0)
    return PlotQuantity{name, "Newton iterations", "1", true, {{"", result.newton_iterations.cast<double>()}}};
  for (Quantity& quantity : list_sampled_quantities(result)) {
    if (!name.starts_with(quantity.name) && !name.starts_with(results::effort_display_name(quantity.name, "N")))
      continue;
    const Samples samples = suppress_round_off(result, quantity.member);
    quantity.samples = &samples;
    const std::vector<QuantityPart> parts = parts_of(quantity, result);
    if (name == quantity.name) return make_plot_quantity(quantity, parts, name, view);
    for (const QuantityPart& part : parts) {
      const std::string part_name = member_name(quantity, part);
      if (results::is_quantity_name(name, part_name)) return make_plot_quantity(quantity, {part}, part_name, view);
      for (std::size_t i = 0; i < part.components.size(); ++i)
        if (name == member_name(quantity, part) + "." + part.components[i])
          return make_component(quantity, part, i, name);
    }
  }
  return std::nullopt;
}

}  // namespace balance::reports
