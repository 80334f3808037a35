#pragma once
/// The rows of goals that are orders, one by one: which sum of parameters the cosine and the sine of each order are.

#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/reports/conditions_sections.hpp"

#include <string>
#include <vector>

namespace balance::reports {

/// Sets order_conditions and order_amplitudes. @param options those of the derivation
void evaluate_orders(ConditionsReportData& view, const Mechanism& mechanism, const ConditionOptions& options);

/// Sets order_names. @pre evaluate_orders()
/// @param start coordinates at which changed mechanisms are assembled
void name_orders(ConditionsReportData& view, const Mechanism& mechanism,
                 const std::vector<conditions::GeometricSymbol>& symbols, const ConditionOptions& options,
                 const std::vector<CoordinateValue>& start);

/// Motions, then the rows with their amplitudes for the study's numbers; "" without orders.
std::string orders_text(const ConditionsReportData& view, const files::TextOptions& options);

/// Adds "orders" to an object, if there are any: the motions and all rows, those that always vanish included.
void add_orders(Json& json, const ConditionsReportData& view);

/// Adds a group "orders", if there are any.
void write_order_rows(hdf5::Hdf5Writer& file, const ConditionsReportData& view);

}  // namespace balance::reports
