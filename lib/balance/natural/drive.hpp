#pragma once
/// Prescribed quantities as rows in natural coordinates. Private to natural.

#include "balance/motion/drive_quantities.hpp"
#include "balance/natural/model.hpp"

namespace balance::natural {

/// Rows whose value is the quantity in internal units; `unit` turns those into SI.
struct DriveRows {
  std::vector<ConstraintRow> rows;
  std::vector<double> unit;
};

/// In the order of DriveValue::value. The angles and coordinates must be scalars of the model.
DriveRows make_drive_rows(const Mechanism& mechanism, const NaturalModel& model, const DriveQuantities& quantities);

/// m · (centre of mass) = B M q as a form (P3 eq. 21), divided by m.
AffineForm make_com_form(const NaturalModel& model);

AffineForm make_tool_form(const Mechanism& mechanism, const NaturalModel& model);

}  // namespace balance::natural
