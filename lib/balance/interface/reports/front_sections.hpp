#pragma once
/// Everything that is told about a trade-off, gathered for the writers.

#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/synthesis/design/pareto_front.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

struct FrontReportData {
  ParetoFront front;
  std::string title;
  std::vector<Goal> goals;           ///< that all designs meet; none: they were not asked to
  std::vector<std::string> figures;  ///< "rms of shaking_force along cycloid", in the order of a point's values
  std::vector<std::string> units;    ///< "" for a sum
  std::vector<FreeNumber> numbers;
  double seconds = 0;                      ///< that all searches were allowed to take
  std::optional<double> interrupted = {};  ///< after so many seconds somebody ended them
  std::vector<std::string> warnings;
};

/// @param options that the front was made with
FrontReportData make_front_report_data(const DesignStudyOptions& options, const DesignSpace& space, ParetoFront front);

/// One word for all points: proved-best if all are, stopped if one is.
Optimality front_optimality(const ParetoFront& front);

/// The table of the points and what is known of them, for people.
std::string front_text(const FrontReportData& view);

/// One JSON document; docs/spec.md says what its keys mean. @param files that were written
/// @param design what design_json says of one of the points; empty: nothing
std::string front_json(const FrontReportData& view, const std::vector<std::string>& files,
                       const std::string& design = {});

/// A line per point under a heading: figures, bound and free numbers, 17 significant digits.
std::string front_csv(const FrontReportData& view);

/// Figures, bounds and free numbers of all points. @throws SystemError, Cancelled as write_result_hdf5
void write_front(const std::string& path, const FrontReportData& view, const Provenance& description,
                 const WriteOptions& options);

}  // namespace balance
