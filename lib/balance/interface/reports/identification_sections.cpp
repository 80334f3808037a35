#include "balance/interface/reports/identification_sections.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/files/report_fields.hpp"
#include "balance/interface/files/result_group.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>

namespace balance::reports {

using files::DisplayUnit;
using files::TextOptions;
using hdf5::Hdf5Writer;
using identification::BaseParameter;
using identification::ChannelReport;
using identification::ChannelSeries;
using identification::DerivedFigure;
using identification::Determination;
using identification::Identification;
using identification::UnknownReport;

namespace {

const char* name_of(Determination determination) {
  switch (determination) {
    case Determination::determined: return "determined";
    case Determination::combined: return "only with others";
    case Determination::nowhere: return "not at all";
    case Determination::not_excited: return "not by this motion";
  }
  return "";
}

/// A value and its deviation with as many digits as the deviation justifies.
std::string deviation_text(double deviation) {
  return std::isfinite(deviation) ? fmt::format("{:.2g}", deviation) : "-";
}

std::string value_text(double value, double deviation) {
  if (!std::isfinite(value)) return "-";
  if (!(deviation > 0)) return fmt::format("{:.5g}", value);
  const int last_digit = static_cast<int>(std::floor(elementary::log10(deviation))) - 1;
  if (last_digit >= 0 || last_digit < -12) return fmt::format("{:.6g}", value);
  return fmt::format("{:.{}f}", value, -last_digit);
}

Json combination_json(const std::vector<UnknownReport>& unknowns, const std::vector<std::pair<int, double>>& others) {
  Json combination = Json::object();
  for (const auto& [index, factor] : others)
    combination[unknowns[static_cast<std::size_t>(index)].unknown.name] = factor;
  return combination;
}

Json missing_json(const Identification& found, const DerivedFigure& figure) {
  Json list = Json::array();
  for (const auto& one : figure.missing) list.push_back(combination_json(found.unknowns, one));
  return list;
}

Json residual_json(const identification::ChannelResidual& residual) {
  return {{"rows", residual.rows},         {"moving_rows", residual.moving_rows}, {"measured", residual.measured},
          {"residual", residual.residual}, {"relative", residual.relative()},     {"spec_residual", residual.spec},
          {"max_rate", residual.max_rate}};
}

ReportFields<BaseParameter> base_fields(const Identification& found) {
  using Row = BaseParameter;
  return {
      {[](const Row& one) { return one.name; }, JsonKey{"name"}, Hdf5Dataset{"unknown whose factor is one", "name"}},
      {[](const Row& one) { return one.unit; }, JsonKey{"unit"}, Hdf5Dataset{"unit", "unit"}},
      {[&](const Row& one) { return combination_json(found.unknowns, one.others); }, JsonKey{"combination"}},
      {[](const Row& one) { return one.value; }, JsonKey{"value"}, Hdf5Dataset{"least-squares value", "value"}},
      {[](const Row& one) { return one.deviation; }, JsonKey{"deviation"},
       Hdf5Dataset{"standard deviation", "deviation"}},
      {[](const Row& one) { return one.spec_value; }, JsonKey{"spec"}, Hdf5Dataset{"value in the spec", "spec"}},
      {[](const Row& one) { return one.is_found; }, JsonKey{"found"}}};
}

Json unknown_json(const UnknownReport& one) {
  return {
      {"name", one.unknown.name},   {"unit", one.unknown.unit},       {"value", one.value},
      {"deviation", one.deviation}, {"spec", one.unknown.spec_value}, {"determination", name_of(one.determination)}};
}

Json channel_json(const ChannelReport& one) {
  return {{"name", one.name},
          {"unit", one.unit},
          {"training", residual_json(one.training)},
          {"validation", one.validation ? residual_json(*one.validation) : Json()},
          {"weight_deviation", one.residual_rms},
          {"gain", one.gain ? Json(*one.gain) : Json()},
          {"gain_deviation", one.gain_deviation ? Json(*one.gain_deviation) : Json()}};
}

}  // namespace

Json identification_json(const Identification& found, const std::string& title, const std::vector<std::string>& files) {
  Json json{{"mechanism", title},
            {"cutoff", found.cutoff},
            {"structural_rank", found.structural_rank},
            {"found_rank", found.found_rank},
            {"condition", found.condition},
            {"channels", files::list_json(found.channels, channel_json)},
            {"base_parameters", files::rows_json(found.base, base_fields(found))},
            {"unknowns", files::list_json(found.unknowns, unknown_json)}};
  json["figures"] = files::list_json(found.figures, [&](const DerivedFigure& one) {
    return Json{{"name", one.name},           {"unit", one.unit},         {"rms", one.rms},
                {"deviation", one.deviation}, {"spec_rms", one.spec_rms}, {"missing", missing_json(found, one)}};
  });
  json["suspicions"] = files::list_json(found.suspicions, [](const identification::Suspicion& one) {
    return Json{{"text", one.text}, {"residual", one.residual}, {"residual_as_read", one.residual_as_read}};
  });
  json["warnings"] = found.warnings;
  json["notes"] = found.notes;
  json["files"] = files;
  return json;
}

namespace {

std::string channel_table(const Identification& found, const TextOptions& options) {
  files::TextTable table;
  const bool has_validation = !found.channels.empty() && found.channels.front().validation.has_value();
  std::vector<std::string> names, units, moving, measured, residual, spec, validated, gains;
  bool has_gains = false;
  for (const ChannelReport& one : found.channels) {
    const DisplayUnit unit = files::find_display_unit(one.unit == "A" ? "1" : one.unit, options.units);
    const auto percent = [&](double part, double whole) {
      return whole > 0 ? fmt::format("{:.3g}", 100 * part / whole) : std::string("-");
    };
    names.push_back(one.name);
    units.push_back(one.unit == "A" ? "A" : unit.name);
    moving.push_back(fmt::format("{}/{}", one.training.moving_rows, one.training.rows));
    measured.push_back(fmt::format("{:.4g}", unit.convert(one.training.measured)));
    residual.push_back(fmt::format("{:.3g}", unit.convert(one.training.residual)));
    spec.push_back(percent(one.training.spec, one.training.measured));
    validated.push_back(percent(one.training.residual, one.training.measured));
    has_gains = has_gains || one.gain;
    gains.push_back(one.gain
                        ? fmt::format("{:.4g}{}", *one.gain,
                                      one.gain_deviation ? fmt::format(" ± {:.2g}", *one.gain_deviation) : " (given)")
                        : "-");
  }
  files::add_text_column(table, "", files::Align::left, names);
  files::add_text_column(table, "unit", files::Align::left, units);
  files::add_text_column(table, "moving", files::Align::right, moving);
  files::add_text_column(table, "rms", files::Align::right, measured);
  files::add_text_column(table, "residual", files::Align::right, residual);
  files::add_text_column(table, "%", files::Align::right, validated);
  files::add_text_column(table, "spec %", files::Align::right, spec);
  if (has_validation) {
    std::vector<std::string> residuals, fastest, ratio;
    for (const ChannelReport& one : found.channels) {
      residuals.push_back(one.validation->measured > 0 ? fmt::format("{:.3g}", 100 * one.validation->relative()) : "-");
      fastest.push_back(fmt::format("{:.3g}", one.validation->max_rate));
      ratio.push_back(fmt::format("{:.3g}", one.training.max_rate));
    }
    files::add_text_column(table, "validation %", files::Align::right, residuals);
    files::add_text_column(table, "fastest", files::Align::right, ratio);
    files::add_text_column(table, "in validation", files::Align::right, fastest);
  }
  if (has_gains) files::add_text_column(table, "gain", files::Align::right, gains);
  return format_table(table, options.width);
}

std::string base_table(const Identification& found, const TextOptions& options) {
  files::TextTable table;
  std::vector<std::string> names, units, values, deviations, spec;
  for (const BaseParameter& one : found.base) {
    const DisplayUnit unit = files::find_display_unit(one.unit, options.units);
    names.push_back(identification::format_combination(found.unknowns, one.name, one.others));
    units.push_back(unit.name);
    values.push_back(one.is_found ? value_text(unit.convert(one.value), unit.convert(one.deviation)) : "not found");
    deviations.push_back(one.is_found ? deviation_text(unit.convert(one.deviation)) : "-");
    spec.push_back(fmt::format("{:.5g}", unit.convert(one.spec_value)));
  }
  files::add_text_column(table, "", files::Align::left, names);
  files::add_text_column(table, "unit", files::Align::left, units);
  files::add_text_column(table, "value", files::Align::right, values);
  files::add_text_column(table, "±", files::Align::right, deviations);
  files::add_text_column(table, "spec", files::Align::right, spec);
  return format_table(table, options.width);
}

/// "crank1: determined my; only with others m, mx, J".
std::string determination_lines(const Identification& found) {
  std::string text;
  for (std::size_t k = 0; k < found.unknowns.size();) {
    const std::string& owner = found.unknowns[k].unknown.owner;
    std::map<Determination, std::vector<std::string>> names;
    bool is_element = false;
    for (; k < found.unknowns.size() && found.unknowns[k].unknown.owner == owner; ++k) {
      const UnknownReport& one = found.unknowns[k];
      is_element = is_element || one.unknown.kind == identification::UnknownKind::body ||
                   one.unknown.kind == identification::UnknownKind::payload;
      names[one.determination].push_back(one.unknown.name.substr(owner.size() + 1));
    }
    if (!is_element && names.size() == 1 && names.begin()->first == Determination::determined) continue;
    std::string line;
    for (const auto& [determination, list] : names)
      line += fmt::format("{}{} {}", line.empty() ? "" : "; ", name_of(determination), fmt::join(list, ", "));
    text += fmt::format("  {}: {}\n", owner, line);
  }
  return text;
}

std::string figures_text(const Identification& found, const TextOptions& options) {
  files::TextTable table;
  std::vector<std::string> names, units, values, deviations, spec;
  std::string missing;
  for (const DerivedFigure& one : found.figures) {
    const DisplayUnit unit = files::find_display_unit(one.unit, options.units);
    names.push_back(one.name);
    units.push_back(unit.name);
    values.push_back(value_text(unit.convert(one.rms), unit.convert(one.deviation)));
    deviations.push_back(std::isnan(one.deviation) ? "unknown" : deviation_text(unit.convert(one.deviation)));
    spec.push_back(fmt::format("{:.5g}", unit.convert(one.spec_rms)));
    if (one.missing.empty()) continue;
    missing += fmt::format("{} also depends on {} that were not measured; its value rests on the spec for them:\n",
                           one.name, count_noun(static_cast<long>(one.missing.size()), "combination", "combinations"));
    for (const auto& combination : one.missing)
      missing += "  " + identification::format_combination(found.unknowns, "", combination) + "\n";
  }
  files::add_text_column(table, "rms along the records", files::Align::left, names);
  files::add_text_column(table, "unit", files::Align::left, units);
  files::add_text_column(table, "value", files::Align::right, values);
  files::add_text_column(table, "±", files::Align::right, deviations);
  files::add_text_column(table, "spec", files::Align::right, spec);
  if (!missing.empty() && found.channels.back().signal.kind != MeasuredSignal::Kind::frame)
    missing += "measure force and moment on the frame (fx, fy, m) to find them\n";
  return format_table(table, options.width) + missing;
}

}  // namespace

std::string identification_text(const Identification& found, const std::string& title, const TextOptions& options) {
  std::string text = title + "\n";
  for (const std::string& note : found.notes) text += "note: " + note + "\n";
  text += fmt::format(
      "low-pass filter at {:.4g} Hz; dry friction of joints at rest is left out\n"
      "{} base parameters of this mechanism, {} found by this motion; condition {:.3g} (columns of norm 1)\n\n",
      found.cutoff, found.structural_rank, found.found_rank, found.condition);
  text += channel_table(found, options) + "\n";
  for (const identification::Suspicion& one : found.suspicions)
    text += fmt::format("warning: {}: read so, the residual is {:.3g} % instead of {:.3g} %\n", one.text,
                        100 * one.residual, 100 * one.residual_as_read);
  for (const std::string& warning : found.warnings) text += "warning: " + warning + "\n";
  if (!found.suspicions.empty() || !found.warnings.empty()) text += "\n";
  text += "base parameters, about the origins of the bodies\n" + base_table(found, options) + "\n";
  if (const std::string lines = determination_lines(found); !lines.empty())
    text += "what the records say of each body\n" + lines + "\n";
  text += figures_text(found, options);
  text +=
      "A joint whose zero differs from the spec's fits as well: its bodies then come out turned. No record shows "
      "this.\n";
  return files::wrap_lines(text, options.width);
}

namespace {

/// Empty for a component of the frame, which has no rate.
std::string rate_unit_of(const ChannelReport& channel, const Mechanism& mechanism) {
  if (channel.signal.kind == MeasuredSignal::Kind::frame) return "";
  const CoordinateId coordinate = mechanism.actuators[static_cast<std::size_t>(channel.signal.index)];
  return is_length_coordinate(mechanism, coordinate) ? "m/s" : "rad/s";
}

void write_series(Hdf5Writer& file, Hdf5Writer::Group parent, const std::string& name, const ChannelSeries& series,
                  const std::string& unit, const std::string& rate_unit) {
  if (series.time.empty()) return;
  const Hdf5Writer::Group group = file.add_group(parent, name);
  const Hdf5Writer::Dimension row = file.add_dimension(group, {"time", "time", "s", {}, {}}, series.time);
  const auto add = [&](const char* variable, const char* long_name, const std::string& si,
                       const std::vector<double>& values) {
    file.add_variable(group, {variable, long_name, si, {row}, {}}, values);
  };
  add("measured", "measured, low-passed", unit, series.measured);
  add("predicted", "predicted by the identified mechanism", unit, series.predicted);
  add("friction", "friction of the identified mechanism, a part of predicted", unit, series.friction);
  if (!rate_unit.empty()) add("rate", "rate of the channel's coordinate", rate_unit, series.rate);
  const std::vector<int> moving(series.moving.begin(), series.moving.end());
  file.add_variable(group, {"moving", "1 where the coordinate is not at rest", "1", {row}, {}},
                    std::span<const int>(moving));
  file.add_variable(group, {"record", "index of the record", "1", {row}, {}}, std::span<const int>(series.record));
}

}  // namespace

void write_identification(const std::string& path, const Identification& found, const files::Provenance& description,
                          const files::WriteOptions& options) {
  files::write_hdf5_file(path, description, options, [&](Hdf5Writer& file) {
    const Hdf5Writer::Group base = file.add_group("base_parameters");
    if (!found.base.empty()) {
      const Hdf5Writer::Dimension row = files::write_rows(file, base, found.base, base_fields(found));
      const Samples covariance = found.base_covariance;
      file.add_variable(base, {"covariance", "covariance of the values", "mixed", {row, row}, {}},
                        hdf5::entries_of(covariance));
    }
    const Hdf5Writer::Group unknowns = file.add_group("unknowns");
    std::vector<std::string> names, determinations;
    std::vector<double> values, deviations, spec;
    for (const UnknownReport& one : found.unknowns) {
      names.push_back(one.unknown.name), determinations.emplace_back(name_of(one.determination));
      values.push_back(one.value), deviations.push_back(one.deviation), spec.push_back(one.unknown.spec_value);
    }
    if (!names.empty()) {
      const Hdf5Writer::Dimension row = file.add_dimension(unknowns, {"name", "unknown", "1", {}, {}}, names);
      file.add_variable(unknowns, {"value", "of the physically consistent mechanism", "mixed", {row}, {}}, values);
      file.add_variable(unknowns, {"deviation", "standard deviation", "mixed", {row}, {}}, deviations);
      file.add_variable(unknowns, {"spec", "value in the spec", "mixed", {row}, {}}, spec);
      file.add_variable(unknowns, {"determination", "what the records say of it", "1", {row}, {}}, determinations);
    }
    const Hdf5Writer::Group channels = file.add_group("channels");
    for (const ChannelReport& one : found.channels) {
      const Hdf5Writer::Group channel = file.add_group(channels, one.name);
      const std::string rate_unit = rate_unit_of(one, found.mechanism);
      write_series(file, channel, "training", one.training_series, one.unit, rate_unit);
      write_series(file, channel, "validation", one.validation_series, one.unit, rate_unit);
    }
  });
}

}  // namespace balance::reports
