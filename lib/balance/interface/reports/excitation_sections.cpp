#include "balance/interface/reports/excitation_sections.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/report_fields.hpp"

#include <fmt/format.h>

#include <cmath>

namespace balance::reports {

using files::DisplayUnit;
using files::TextOptions;
using identification::DerivedFigure;
using identification::Determination;
using identification::Excitation;
using identification::ExcitationLimitUse;
using identification::ExcitedChannel;
using identification::ExcitedParameter;
using identification::MotionInformation;

namespace {

Json combination_json(const Excitation& excitation, const std::vector<std::pair<int, double>>& others) {
  Json combination = Json::object();
  for (const auto& [index, factor] : others)
    combination[excitation.unknowns[static_cast<std::size_t>(index)].unknown.name] = factor;
  return combination;
}

Json number_json(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json information_json(const MotionInformation& information) {
  return {{"log_det", number_json(information.log_det)}, {"condition", number_json(information.condition)}};
}

/// By how much deviations shrink against the median of the random series, on the geometric mean over the confidence
/// ellipsoid's axes.
double mean_gain(const Excitation& excitation) {
  return elementary::exp((excitation.found.log_det - excitation.median_random.log_det) /
                         (2 * static_cast<double>(excitation.structural_rank)));
}

std::string limits_table(const Excitation& excitation, const TextOptions& options) {
  files::TextTable table;
  std::vector<std::string> names, units, lower, upper, lowest, highest, used;
  for (const ExcitationLimitUse& one : excitation.limits) {
    const DisplayUnit unit = files::find_display_unit(one.unit, options.units);
    const auto number = [&](double value) { return fmt::format("{:.4g}", unit.convert(value)); };
    names.push_back(one.name + (one.is_given ? "" : " (assumed)"));
    units.push_back(unit.name);
    lower.push_back(number(one.limit.lower)), upper.push_back(number(one.limit.upper));
    lowest.push_back(number(one.lowest)), highest.push_back(number(one.highest));
    used.push_back(one.is_active ? "active" : fmt::format("{:.0f} %", 100 * one.used()));
  }
  files::add_text_column(table, "limits", files::Align::left, names);
  files::add_text_column(table, "unit", files::Align::left, units);
  files::add_text_column(table, "from", files::Align::right, lower);
  files::add_text_column(table, "to", files::Align::right, upper);
  files::add_text_column(table, "least", files::Align::right, lowest);
  files::add_text_column(table, "most", files::Align::right, highest);
  files::add_text_column(table, "used", files::Align::right, used);
  return format_table(table, options.width);
}

std::string channels_table(const Excitation& excitation, const TextOptions& options) {
  files::TextTable table;
  std::vector<std::string> names, units, rms, peak, noise_deviations, moving;
  for (const ExcitedChannel& one : excitation.channels) {
    const DisplayUnit unit = files::find_display_unit(one.unit, options.units);
    names.push_back(one.name);
    units.push_back(unit.name);
    rms.push_back(fmt::format("{:.4g}", unit.convert(one.rms)));
    peak.push_back(fmt::format("{:.4g}", unit.convert(one.peak)));
    noise_deviations.push_back(fmt::format("{:.3g}", unit.convert(one.noise_deviation)) +
                               (one.is_noise_given ? "" : " (assumed)"));
    moving.push_back(fmt::format("{:.0f} %", 100 * one.moving_share));
  }
  files::add_text_column(table, "measured", files::Align::left, names);
  files::add_text_column(table, "unit", files::Align::left, units);
  files::add_text_column(table, "rms", files::Align::right, rms);
  files::add_text_column(table, "peak", files::Align::right, peak);
  files::add_text_column(table, "noise", files::Align::right, noise_deviations);
  files::add_text_column(table, "moving", files::Align::right, moving);
  return format_table(table, options.width);
}

std::string parameters_table(const Excitation& excitation, const TextOptions& options) {
  files::TextTable table;
  std::vector<std::string> names, units, spec, expected, random;
  for (const ExcitedParameter& one : excitation.base) {
    const DisplayUnit unit = files::find_display_unit(one.parameter.unit, options.units);
    const auto deviation = [&](double value) {
      return std::isfinite(value) ? fmt::format("{:.2g}", unit.convert(value)) : std::string("-");
    };
    names.push_back(identification::format_combination(excitation.unknowns, one.parameter.name, one.parameter.others));
    units.push_back(unit.name);
    spec.push_back(fmt::format("{:.5g}", unit.convert(one.parameter.spec_value)));
    expected.push_back(one.parameter.is_found ? deviation(one.parameter.deviation) : "not shown");
    random.push_back(deviation(one.random_deviation));
  }
  files::add_text_column(table, "", files::Align::left, names);
  files::add_text_column(table, "unit", files::Align::left, units);
  files::add_text_column(table, "spec", files::Align::right, spec);
  files::add_text_column(table, "±", files::Align::right, expected);
  files::add_text_column(table, "± random", files::Align::right, random);
  return format_table(table, options.width);
}

std::string hidden_text(const Excitation& excitation) {
  std::string text;
  std::vector<std::string> nowhere;
  for (const identification::UnknownReport& one : excitation.unknowns)
    if (one.determination == Determination::nowhere) nowhere.push_back(one.unknown.name);
  if (!nowhere.empty()) text += "no motion shows " + join_with_conjunction(nowhere, "and") + "\n";
  for (const DerivedFigure& one : excitation.figures) {
    if (one.missing.empty()) continue;
    text += fmt::format("{} also depends on {} that no effort shows:\n", one.name,
                        count_noun(static_cast<long>(one.missing.size()), "combination", "combinations"));
    for (const auto& combination : one.missing)
      text += "  " + identification::format_combination(excitation.unknowns, "", combination) + "\n";
  }
  return text;
}

}  // namespace

std::string excitation_text(const Excitation& excitation, const Mechanism& mechanism, const std::string& title,
                            const ExcitedSpec* spec, const TextOptions& options) {
  const DisplayUnit time = files::find_display_unit("s", options.units);
  std::string text = title + "\n";
  for (const std::string& note : excitation.notes) text += "note: " + note + "\n";
  std::vector<std::string> names;
  for (const CoordinateId c : excitation.coordinates) names.push_back(mechanism.coordinates[c].name);
  text += fmt::format("{} in {} of {:.6g} {}{}, at rest at both ends\n", join_with_conjunction(names, "and"),
                      count_noun(excitation.motion.harmonics(), "harmonic", "harmonics"),
                      time.convert(excitation.motion.period()), time.name,
                      excitation.periods > 1 ? fmt::format(", {} times", excitation.periods) : "");
  text += fmt::format(
      "log det of the information {:.2f}; of random series: median {:.2f}, best {:.2f} of {}\n"
      "condition number of columns of norm 1: {:.3g}; of random series: median {:.3g}\n"
      "deviations are {:.3g} times smaller than along the median series (geometric mean)\n"
      "{} base parameters of this mechanism, {} shown by this motion\n",
      excitation.found.log_det, excitation.median_random.log_det, excitation.start.log_det, excitation.random_series,
      excitation.found.condition, excitation.median_random.condition, mean_gain(excitation), excitation.structural_rank,
      excitation.found_rank);
  if (excitation.has_loops)
    text += fmt::format("mobility along the motion: at least {:.3g}\n", excitation.min_mobility);
  if (excitation.is_time_exhausted) text += "the search ended for lack of time: --seconds gives it more\n";
  text += "\n" + limits_table(excitation, options) + "\n" + channels_table(excitation, options) + "\n";
  text += "expected deviations for this noise, white at the sampling rate\n" + parameters_table(excitation, options);
  if (const std::string hidden = hidden_text(excitation); !hidden.empty()) text += "\n" + hidden;
  if (spec != nullptr)
    text += fmt::format(
        "\nthe trajectory follows the series to {:.2g} of the largest position and {:.2g} of the largest "
        "acceleration\n",
        spec->position_error, spec->acceleration_error);
  return files::wrap_lines(text, options.width);
}

Json excitation_json(const Excitation& excitation, const Mechanism& mechanism, const std::string& title,
                     const ExcitedSpec* spec, const std::vector<std::string>& files) {
  Json json{{"mechanism", title},
            {"duration", excitation.duration()},
            {"period", excitation.motion.period()},
            {"harmonics", excitation.motion.harmonics()},
            {"information", information_json(excitation.found)},
            {"median_random", information_json(excitation.median_random)},
            {"best_random", information_json(excitation.start)},
            {"random_series", excitation.random_series},
            {"deviation_ratio", mean_gain(excitation)},
            {"structural_rank", excitation.structural_rank},
            {"found_rank", excitation.found_rank},
            {"mobility", excitation.has_loops ? Json(excitation.min_mobility) : Json()},
            {"local_searches", excitation.local_searches},
            {"evaluations", excitation.evaluations},
            {"time_exhausted", excitation.is_time_exhausted}};
  Json series = Json::array();
  for (std::size_t i = 0; i < excitation.coordinates.size(); ++i) {
    const VectorX u = excitation.coefficients.row(static_cast<Eigen::Index>(i)).transpose();
    const MatrixX factors = excitation.motion.series(u);
    std::vector<double> sines, cosines;
    for (Eigen::Index k = 0; k < factors.rows(); ++k) sines.push_back(factors(k, 0)), cosines.push_back(factors(k, 1));
    series.push_back({{"coordinate", mechanism.coordinates[excitation.coordinates[i]].name},
                      {"offset", u[0]},
                      {"sine", sines},
                      {"cosine", cosines}});
  }
  json["series"] = series;
  json["limits"] = files::list_json(excitation.limits, [](const ExcitationLimitUse& one) {
    return Json{{"name", one.name},         {"unit", one.unit},       {"lower", one.limit.lower},
                {"upper", one.limit.upper}, {"lowest", one.lowest},   {"highest", one.highest},
                {"given", one.is_given},    {"active", one.is_active}};
  });
  json["channels"] = files::list_json(excitation.channels, [](const ExcitedChannel& one) {
    return Json{
        {"name", one.name}, {"unit", one.unit}, {"noise", one.noise_deviation}, {"noise_given", one.is_noise_given},
        {"rms", one.rms},   {"peak", one.peak}, {"moving", one.moving_share}};
  });
  json["base_parameters"] = files::list_json(excitation.base, [&](const ExcitedParameter& one) {
    return Json{{"name", one.parameter.name},
                {"unit", one.parameter.unit},
                {"combination", combination_json(excitation, one.parameter.others)},
                {"spec", one.parameter.spec_value},
                {"deviation", number_json(one.parameter.deviation)},
                {"random_deviation", number_json(one.random_deviation)},
                {"shown", one.parameter.is_found}};
  });
  Json hidden = Json::array();
  for (const identification::UnknownReport& one : excitation.unknowns)
    if (one.determination == Determination::nowhere) hidden.push_back(one.unknown.name);
  json["hidden"] = hidden;
  json["hidden_combinations"] = files::list_json(excitation.figures, [&](const DerivedFigure& one) {
    Json list = Json::array();
    for (const auto& combination : one.missing) list.push_back(combination_json(excitation, combination));
    return Json{{"name", one.name}, {"missing", list}};
  });
  json["trajectory"] = spec == nullptr ? Json()
                                       : Json{{"position_error", spec->position_error},
                                              {"acceleration_error", spec->acceleration_error},
                                              {"effort_error", number_json(spec->effort_error)}};
  json["notes"] = excitation.notes;
  json["files"] = files;
  return json;
}

}  // namespace balance::reports
