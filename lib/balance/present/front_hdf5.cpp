// A trade-off as an HDF5 file.

#include "balance/present/front_view.hpp"
#include "balance/present/names.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/result_group.hpp"

#include <span>

namespace balance {
namespace {

using Dimension = Hdf5Writer::Dimension;
using Group = Hdf5Writer::Group;

constexpr Group front_root_group{};

/// A row per point.
Samples rows_of(const ParetoFront& front, Eigen::Index columns, VectorX (*row)(const ParetoPoint&)) {
  Samples rows(static_cast<Eigen::Index>(front.points.size()), columns);
  for (std::size_t k = 0; k < front.points.size(); ++k)
    rows.row(static_cast<Eigen::Index>(k)) = row(front.points[k]).transpose();
  return rows;
}

std::span<const double> values_of(const Samples& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

std::vector<std::string> point_names(const ParetoFront& front) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < front.points.size(); ++k) names.push_back(std::to_string(k + 1));
  return names;
}

void add_points(Hdf5Writer& file, const FrontReportData& view) {
  const ParetoFront& front = view.front;
  if (front.points.empty()) return;
  std::vector<std::string> paths;
  for (const FreeNumber& number : view.numbers) paths.push_back(number.key_path);
  const Dimension point =
      file.add_dimension(front_root_group, {"point", "of the front", "1", {}, {}}, point_names(front));
  const Dimension figure =
      file.add_dimension(front_root_group, {"figure", "what is traded", "1", {}, {}}, view.figures);
  const Dimension number =
      file.add_dimension(front_root_group, {"free_number", "key path in the spec", "1", {}, {}}, paths);
  const auto figures = static_cast<Eigen::Index>(view.figures.size()),
             numbers = static_cast<Eigen::Index>(paths.size());
  const auto add = [&](const char* name, const char* long_name, std::vector<Dimension> dimensions,
                       const Samples& rows) {
    file.add_variable(front_root_group, {name, long_name, "mixed", std::move(dimensions), {}}, values_of(rows));
  };
  add("value", "figures of the points, SI", {point, figure},
      rows_of(front, figures, [](const ParetoPoint& p) { return p.values; }));
  add("limit", "what the other figures were limited to; NaN: not limited", {point, figure},
      rows_of(front, figures, [](const ParetoPoint& p) { return p.limits; }));
  add("minimized", "index of the figure that was minimized", {point},
      rows_of(front, 1, [](const ParetoPoint& p) { return VectorX::Constant(1, p.minimized).eval(); }));
  add("lower_bound", "what no design within the limits has less of; NaN: not proved", {point},
      rows_of(front, 1, [](const ParetoPoint& p) { return VectorX::Constant(1, p.lower_bound).eval(); }));
  add("free_numbers", "values of the free numbers, SI; free parameters as written", {point, number},
      rows_of(front, numbers, [](const ParetoPoint& p) { return p.report.outcome.x; }));
  const auto cases = static_cast<Eigen::Index>(front.points.front().report.load_cases.size());
  if (cases == 0) return;
  std::vector<std::string> names;
  for (Eigen::Index k = 0; k < cases; ++k) names.push_back(std::to_string(k + 1));
  const Dimension load = file.add_dimension(front_root_group, {"load_case", "of design: for", "1", {}, {}}, names);
  add("free_numbers_in_case", "values of the free numbers with the loads of every case, SI; free parameters as written",
      {point, load, number}, rows_of(front, cases * numbers, [](const ParetoPoint& p) {
        VectorX all(static_cast<Eigen::Index>(p.report.load_cases.size()) * p.report.outcome.x.size());
        Eigen::Index at = 0;
        for (const LoadCaseReport& one : p.report.load_cases) all.segment(at, one.x.size()) = one.x, at += one.x.size();
        return all;
      }));
}

}  // namespace

void write_front(const std::string& path, const FrontReportData& view, const Provenance& description,
                 const WriteOptions& options) {
  AtomicFile pending(path, options.existing, options.temporary_tag);
  const bool compress = options.compression == Compression::gzip;
  Hdf5Writer file(pending.descriptor(), path,
                  compress ? Hdf5Writer::Storage::compressed : Hdf5Writer::Storage::contiguous);
  write_source_attributes(file, description);
  file.set_attribute(front_root_group, "goal", join_goal_names(view.goals));
  file.set_attribute(front_root_group, "optimality", name_of(front_optimality(view.front)));
  file.set_attribute(front_root_group, "stopped", view.front.is_budget_exhausted ? "yes" : "no");
  add_points(file, view);
  file.close();
  throw_if_cancelled(options);
  pending.commit();
}

}  // namespace balance
