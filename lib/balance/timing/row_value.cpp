#include "balance/timing/row_value.hpp"

#include <cmath>

namespace balance {

namespace {

constexpr double right_angle = 1e-5;  // cosine

}  // namespace

RowValue value_of_row(const PathModel& model, const PathMoment& moment) {
  const LimitRow& row = model.rows[static_cast<std::size_t>(moment.row)];
  VectorX columns(model.value.functions());
  model.value.at(model.value.panel_at(moment.s, 0, model.value.panels().size()), moment.s, columns.data());
  const auto part = [&](int column) {
    return column < 0 ? VectorX(VectorX::Zero(row.count)) : VectorX(columns.segment(column, row.count));
  };
  const VectorX a = part(row.a), b = part(row.b), d = part(row.d);
  RowValue here;
  here.value = a * moment.u + b * (moment.v * moment.v) + part(row.c) + d * moment.v;
  if (row.count == 1) here.value[0] -= row.middle;
  here.magnitude = here.value.norm();
  if (!(here.magnitude > 0)) return here;
  const VectorX along = here.value / here.magnitude;
  here.by_u = along.dot(a);
  here.by_x = along.dot(b) + (moment.v > 0 ? along.dot(d) / (2 * moment.v) : 0);
  here.tangent = !row.limits_acceleration || !(std::abs(here.by_u) > right_angle * a.norm());
  return here;
}

}  // namespace balance
