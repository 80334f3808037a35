#include "balance/timing/row_value.hpp"

#include <cmath>

namespace balance {

namespace {

constexpr double right_angle_tolerance = 1e-5;  // cosine

}  // namespace

ConstraintValue evaluate_constraint(const PathModel& model, const PathPoint& moment) {
  const PathConstraintRow& row = model.rows[static_cast<std::size_t>(moment.row)];
  VectorX columns(model.value.function_count());
  model.value.evaluate(model.value.find_panel(moment.s, 0, model.value.panels().size()), moment.s, columns.data());
  const auto part = [&](int column) {
    return column < 0 ? VectorX(VectorX::Zero(row.count)) : VectorX(columns.segment(column, row.count));
  };
  const VectorX a = part(row.a), b = part(row.b), d = part(row.d);
  ConstraintValue here;
  here.value = a * moment.u + b * (moment.v * moment.v) + part(row.c) + d * moment.v;
  if (row.count == 1) here.value[0] -= row.centre;
  here.magnitude = here.value.norm();
  if (!(here.magnitude > 0)) return here;
  const VectorX along = here.value / here.magnitude;
  here.d_du = along.dot(a);
  here.d_dx = along.dot(b) + (moment.v > 0 ? along.dot(d) / (2 * moment.v) : 0);
  here.is_velocity_limited = !row.has_acceleration_term || !(std::abs(here.d_du) > right_angle_tolerance * a.norm());
  return here;
}

}  // namespace balance
