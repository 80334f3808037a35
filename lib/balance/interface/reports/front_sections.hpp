#pragma once
/// Report data of a trade-off.

#include "balance/interface/files/json.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/synthesis/design/pareto_front.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::reports {

struct FrontReportData {
  design::ParetoFront front;
  std::string title;
  std::vector<Goal> goals;           ///< met by all designs; none: not required
  std::vector<std::string> figures;  ///< "rms of shaking_force along cycloid", in the order of a point's values
  std::vector<std::string> units;    ///< "" for a sum
  std::vector<FreeNumber> numbers;
  double seconds = 0;                      ///< time limit of all searches [s]
  std::optional<double> interrupted = {};  ///< time at which they were interrupted [s]
  std::vector<std::string> warnings;
};

/// @param options those of the front
FrontReportData make_front_report_data(const DesignStudyOptions& options, const DesignSpace& space,
                                       design::ParetoFront front);

/// Common optimality of all points: proved-best if all are, stopped if one is.
design::Optimality front_optimality(const design::ParetoFront& front);

/// Table of the points and what is known of them.
std::string front_text(const FrontReportData& view, const files::TextOptions& options = {});

/// One JSON document; docs/spec.md describes its keys. @param files that were written
/// @param design design_json() of one of the points; null: none
Json front_json(const FrontReportData& view, const std::vector<std::string>& files, const Json& design = {});

/// One line per point under a heading: figures, bound and free numbers, 17 significant digits.
std::string front_csv(const FrontReportData& view);

/// Writes figures, bounds and free numbers of all points. @throws SystemError, Cancelled as write_result_hdf5
void write_front(const std::string& path, const FrontReportData& view, const files::Provenance& description,
                 const files::WriteOptions& options);

}  // namespace balance::reports
