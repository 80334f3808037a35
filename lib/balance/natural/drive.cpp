#include "balance/natural/drive.hpp"

namespace balance::natural {

Form com_form(const Model& model) {
  Form sum = constant_form(model.resting_moment / model.total_mass);
  for (const MassEntry& entry : model.mass) sum = sum + Form{{}, {{entry.column, entry.value / model.total_mass}}};
  return sum;
}

Form tool_form(const Mechanism& mechanism, const Model& model) {
  const Tool& tool = mechanism.tool.value();
  return model.bodies[static_cast<std::size_t>(tool.body)].place(planar(tool.position, model.length()));
}

DriveRows drive_rows(const Mechanism& mechanism, const Model& model, const DriveQuantities& quantities) {
  DriveRows drive;
  const auto add_components = [&](const std::vector<int>& components, const Form& place) {
    for (const int k : components) {
      drive.rows.push_back({.left = constant_form(k == 0 ? Complex(1) : imaginary), .right = place});
      drive.unit.push_back(model.length());
    }
  };
  if (!quantities.point.empty()) add_components(quantities.point, tool_form(mechanism, model));
  if (!quantities.com.empty()) add_components(quantities.com, com_form(model));
  if (quantities.tool_angle) {
    const int angle = model.bodies[static_cast<std::size_t>(mechanism.tool->body)].angle;
    Row row;
    row.scalars.push_back({angle, 1});
    row.constant = model.tool_turns;
    drive.rows.push_back(row);
    drive.unit.push_back(1);
  }
  for (const int c : quantities.coordinates) {
    const JointCoordinate& coordinate = model.coordinates[static_cast<std::size_t>(c)];
    const double unit = coordinate.angle ? 1 : model.length();
    Row row;
    for (const ScalarTerm& term : coordinate.form.terms) row.scalars.push_back({term.scalar, term.coefficient / unit});
    row.constant = -coordinate.form.constant / unit;
    drive.rows.push_back(row);
    drive.unit.push_back(unit);
  }
  return drive;
}

}  // namespace balance::natural
