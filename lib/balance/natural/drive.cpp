#include "balance/natural/drive.hpp"

namespace balance::natural {

AffineForm make_com_form(const NaturalModel& model) {
  AffineForm sum = make_constant_form(model.ground_disc_moment / model.total_mass);
  for (const MassEntry& entry : model.mass)
    sum = sum + AffineForm{{}, {{entry.column, entry.value / model.total_mass}}};
  return sum;
}

AffineForm make_tool_form(const Mechanism& mechanism, const NaturalModel& model) {
  const Tool& tool = mechanism.tool.value();
  return model.bodies[static_cast<std::size_t>(tool.body)].place(to_complex(tool.position, model.length()));
}

DriveRows make_drive_rows(const Mechanism& mechanism, const NaturalModel& model, const DriveQuantities& quantities) {
  DriveRows drive;
  const auto add_components = [&](const std::vector<int>& components, const AffineForm& place) {
    for (const int k : components) {
      drive.rows.push_back({.left = make_constant_form(k == 0 ? Complex(1) : imaginary), .right = place});
      drive.unit.push_back(model.length());
    }
  };
  if (!quantities.point.empty()) add_components(quantities.point, make_tool_form(mechanism, model));
  if (!quantities.com.empty()) add_components(quantities.com, make_com_form(model));
  if (quantities.tool_angle) {
    const int angle = model.bodies[static_cast<std::size_t>(mechanism.tool->body)].angle;
    ConstraintRow row;
    row.scalars.push_back({angle, 1});
    row.constant = model.tool_angle_offset;
    drive.rows.push_back(row);
    drive.unit.push_back(1);
  }
  for (const int c : quantities.coordinates) {
    const JointCoordinate& coordinate = model.coordinates[static_cast<std::size_t>(c)];
    const double unit = coordinate.angle ? 1 : model.length();
    ConstraintRow row;
    for (const ScalarTerm& term : coordinate.form.terms) row.scalars.push_back({term.scalar, term.coefficient / unit});
    row.constant = -coordinate.form.constant / unit;
    drive.rows.push_back(row);
    drive.unit.push_back(unit);
  }
  return drive;
}

}  // namespace balance::natural
