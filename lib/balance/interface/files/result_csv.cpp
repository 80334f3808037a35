#include "balance/interface/files/result_file.hpp"

#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/text_table.hpp"
#include "balance/mechanics/results/quantities.hpp"

#include <fmt/format.h>

#include <iterator>
#include <stdexcept>

namespace balance::files {

using results::ColumnKind;

namespace {

constexpr std::size_t flush_bytes = 1 << 20;  // bytes buffered before they are written

/// The names of a quantity's columns: its name followed or preceded by labels.
std::vector<std::string> column_names(const Quantity& quantity, const RunResult& r) {
  const auto append_labels = [](const std::string& name, const std::vector<std::string>& labels) {
    std::vector<std::string> names;
    for (const std::string& label : labels) names.push_back(name + "." + label);
    return names;
  };
  const auto prepend_labels = [&](const std::vector<std::string>& labels) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const std::string& unit = quantity.unit_of(i, labels.size());
      names.push_back(labels[i] + "." + results::effort_display_name(quantity.short_name, unit));
    }
    return names;
  };
  const auto append_to_each = [&](const std::vector<std::string>& names, const std::vector<std::string>& labels) {
    std::vector<std::string> columns;
    for (const std::string& name : names)
      for (std::string& label : append_labels(name, labels)) columns.push_back(std::move(label));
    return columns;
  };
  switch (quantity.columns) {
    case ColumnKind::single: return {quantity.name};
    case ColumnKind::coordinate: return prepend_labels(r.coordinate_names);
    case ColumnKind::actuator: return prepend_labels(r.actuator_names);
    case ColumnKind::axis: return append_labels(quantity.name, results::axis_labels(r.axes));
    case ColumnKind::quaternion: return append_labels(quantity.name, results::quaternion_labels());
    case ColumnKind::constraint: return prepend_labels(r.constraint_names);
    case ColumnKind::sliding: return prepend_labels(r.sliding_names);
    case ColumnKind::joint: return prepend_labels(r.joint_names);
    case ColumnKind::joint_axis: return append_to_each(prepend_labels(r.joint_names), results::axis_labels(r.axes));
    case ColumnKind::body: return prepend_labels(r.body_names);
    case ColumnKind::body_axis: return append_to_each(prepend_labels(r.body_names), results::axis_labels(r.axes));
    case ColumnKind::body_quaternion: return append_to_each(prepend_labels(r.body_names), results::quaternion_labels());
  }
  return {};
}

std::string header(const std::vector<Quantity>& quantities, const RunResult& r) {
  std::string line = "time [s]";
  for (const Quantity& quantity : quantities) {
    const std::vector<std::string> names = column_names(quantity, r);
    if (static_cast<Eigen::Index>(names.size()) != quantity.samples->cols()) {
      throw std::invalid_argument(quantity.name + ": as many columns as names are needed");
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string& unit = quantity.unit_of(i, names.size());
      line += "," + escape_csv_field(fmt::format("{} [{}]", names[i], unit));
    }
  }
  return line + ",newton_iterations [1]\n";
}

void append_row(fmt::memory_buffer& rows, const std::vector<Quantity>& quantities, const RunResult& r, Eigen::Index k) {
  auto out = std::back_inserter(rows);
  fmt::format_to(out, "{:.17g}", r.time[k]);
  for (const Quantity& quantity : quantities) {
    for (Eigen::Index column = 0; column < quantity.samples->cols(); ++column) {
      fmt::format_to(out, ",{:.17g}", (*quantity.samples)(k, column));
    }
  }
  fmt::format_to(out, ",{}\n", r.newton_iterations[k]);
}

}  // namespace

void write_result_csv(const std::string& path, const RunResult& result, const WriteOptions& options) {
  if (result.time.size() == 0) throw std::invalid_argument("only a result with samples is written");
  const std::vector<Quantity> quantities = list_sampled_quantities(result);
  for (const Quantity& quantity : quantities) {
    if (quantity.samples->rows() != result.time.size()) {
      throw std::invalid_argument(quantity.name + ": one row per sample is needed");
    }
  }
  if (result.newton_iterations.size() != result.time.size()) {
    throw std::invalid_argument("newton_iterations: one entry per sample is needed");
  }
  AtomicFile output(path, options.existing, options.temporary_tag);
  output.write(header(quantities, result));
  fmt::memory_buffer rows;
  for (Eigen::Index k = 0; k < result.time.size(); ++k) {
    append_row(rows, quantities, result, k);
    if (rows.size() < flush_bytes) continue;
    throw_if_cancelled(options);
    output.write({rows.data(), rows.size()});
    rows.clear();
  }
  output.write({rows.data(), rows.size()});
  throw_if_cancelled(options);
  output.commit();
}

}  // namespace balance::files
