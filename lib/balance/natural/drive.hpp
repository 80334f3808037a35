#pragma once
/// Prescribed quantities as rows in natural coordinates. Private to natural.

#include "balance/motion/drive_quantities.hpp"
#include "balance/natural/model.hpp"

namespace balance::natural {

/// Rows whose value is the quantity in internal units; `unit` turns those into SI.
struct DriveRows {
  std::vector<Row> rows;
  std::vector<double> unit;
};

/// In the order of DriveValue::value. The angles and coordinates must be scalars of the model.
DriveRows drive_rows(const Mechanism& mechanism, const Model& model, const DriveQuantities& quantities);

/// m · (centre of mass) = B M q as a form (P3 eq. 21), divided by m.
Form com_form(const Model& model);

Form tool_form(const Mechanism& mechanism, const Model& model);

}  // namespace balance::natural
